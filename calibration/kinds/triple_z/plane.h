#pragma once

#include <span>
#include <string>
#include <vector>

#include "calibration/estimate/tilt_plane.h"
#include "sim/machine/kinds/triple_z/drawing.h"
#include "sim/machine/screw_levelling.h"

namespace caltwin {

/// A plane through touches of a bed,  z = a x + b y + c, as the published text has it.
struct BedPlane {
  TiltPlane fit{};  ///< About the origin: c = height.
  int points = 0;

  double a() const { return fit.slope_x.value; }
  double b() const { return fit.slope_y.value; }
  double c_mm() const { return fit.height_mm.value; }
  double At_mm(const Eigen::Vector2d& at_mm) const {
    return a() * at_mm[0] + b() * at_mm[1] + c_mm();
  }
  bool is_told() const { return fit.slope_x.identifiable && fit.slope_y.identifiable; }
  /// @name The published angles: arctan of a, of b, and of both together [deg].
  double TiltX_deg() const;
  double TiltY_deg() const;
  double Tilt_deg() const;
};
/// Least squares; where the touches contradict `sigma_mm` the uncertainty is that of
/// their own scatter, with Student's t for their few degrees of freedom
/// (ScatterFactor).
BedPlane FitBedPlane(std::span<const BedTouch> touches,
                     double sigma_mm,
                     bool is_sigma_stated = true);

/// What to do with each screw, three ways of saying it.
enum class OffsetRule {
  kFormula,  ///< reference - z_i, less the smallest: as the published formula.
  kExample,  ///< z_i, less the smallest: as the published example; it doubles the tilt.
  kLevel     ///< level - z_i: levels at `level_mm`.
};
/// How much each screw is to be raised [mm], z_i the plane's height over it.
Vec3<double> ScrewOffsets_mm(const BedPlane& plane,
                             const Pivots<double>& pivots_mm,
                             double level_mm,
                             OffsetRule rule);

/// How far touches are from where they ought to be, as the published text states it.
struct LevelReport {
  double mean_mm = 0;  ///< Of the magnitudes.
  double max_mm = 0;
  double std_mm = 0;  ///< Of the magnitudes, over their number (of a population).
  int count = 0;
};
LevelReport ReportLevel(std::span<const BedTouch> touches, double level_mm);

/// What the plane's own degrees of freedom say of it.
std::vector<std::string> PlaneVerdicts(const BedPlane& plane);

}  // namespace caltwin
