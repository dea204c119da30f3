#pragma once

#include <span>
#include <vector>

#include "calibration/estimate/uncertain.h"
#include "sim/machine/axis.h"

namespace caltwin {

/// A plane fitted to touched heights.
struct TiltPlane {
  Uncertain height_mm{};  ///< At `about_mm`.
  Uncertain slope_x{};    ///< dz/dx [mm/mm]: positive rises towards +x.
  Uncertain slope_y{};
  double slope_covariance = 0;         ///< Of slope_x with slope_y, as their sd.
  std::vector<double> residuals_mm{};  ///< Touched less plane, in the order given.
  double rms_mm = 0;                   ///< Of the residuals, over the points.
  double worst_mm = 0;                 ///< Largest residual, without sign.
  /// Points beyond the three that any plane fits exactly. At 0 the residuals are zero
  /// by construction and say nothing of flatness.
  int dof = 0;
  double chi2_per_dof = 0;
};

/// Least squares plane  z = height + slope_x (x - x0) + slope_y (y - y0)  through
/// touched points, each z with standard deviation sigma_mm (> 0).
///
/// Neglects that a tilted surface is touched beside the tip's lowest point: the tip
/// compensated along z alone stands too high by R slope^2 / 2, the same everywhere
/// (0.5 nm for 1 mm and 1 mrad). Not identifiable with fewer than three points or with
/// points on one line.
TiltPlane FitTiltPlane(std::span<const Vec3<double>> points_mm,
                       double sigma_mm,
                       const Vec3<double>& about_mm = Vec3<double>::Zero());

}  // namespace caltwin
