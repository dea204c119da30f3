#pragma once

#include <functional>
#include <optional>

#include "sim/machine/axis.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {

/// The bed under a delta's nozzle: a plane and the shapes it is bent to, each of which
/// raises the rim (of `radius_mm`) against the middle.
///
///   height + slope_x x + slope_y y + bowl u^2 + cylinder_x (x / R)^2 + cylinder_y
///   (y / R)^2 + twist 2 x y / R^2,   u^2 = (x^2 + y^2) / R^2
template <typename T>
struct DeltaBed {
  T height_mm{};
  T slope_x{};
  T slope_y{};
  T bowl_mm{};
  T cylinder_x_mm{};
  T cylinder_y_mm{};
  T twist_mm{};
  double radius_mm = 100;

  T Height_mm(const T& x_mm, const T& y_mm) const {
    const T u = x_mm / T(radius_mm), v = y_mm / T(radius_mm);
    return height_mm + slope_x * x_mm + slope_y * y_mm + bowl_mm * (u * u + v * v) +
           cylinder_x_mm * u * u + cylinder_y_mm * v * v + T(2) * twist_mm * u * v;
  }
};

/// What a delta touches with: its nozzle, or a sprung probe beside it whose tip gives
/// way along the tool by the pre-travel before it triggers.
struct DeltaTip {
  Vec3<double> off_mm = Vec3<double>::Zero();  ///< From the nozzle, on the effector.
  double pretravel_mm = 0;                     ///< 0: nothing gives way.

  bool IsNozzle() const { return pretravel_mm == 0 && off_mm.isZero(0); }
  /// From the nozzle, when it triggers.
  Vec3<double> AtTrigger_mm() const { return off_mm + pretravel_mm * Unit(Axis::kZ); }
};

/// The motors' commanded travels while a firmware goes straight down somewhere, by the
/// height that it believes the nozzle at. Not finite where an arm is too short.
using DeltaDescent = std::function<Vec3<double>(double z_mm)>;

/// The height that a delta's firmware believes its nozzle at when the tip touches the
/// bed on that descent; searched for from `near_mm`. nullopt where an arm is too short.
std::optional<double> DeltaTouchHeight_mm(const DeltaBuild<double>& build,
                                          const DeltaBed<double>& bed,
                                          const DeltaDescent& descent,
                                          double near_mm,
                                          const DeltaTip& tip = {});

/// Where a delta touches its bed when its firmware, believing `settings`, goes straight
/// down at (x, y): the motors' commanded travels at the trigger. The settings know
/// nothing of the tip. nullopt where an arm is too short.
std::optional<Vec3<double>> DeltaTouchMotors(const DeltaBuild<double>& build,
                                             const DeltaBed<double>& bed,
                                             const DeltaModel<double>& settings,
                                             double x_mm,
                                             double y_mm,
                                             const DeltaTip& tip = {});

/// How a delta with these settings prints: over a disc of that radius on the bed plane
/// z = 0 as it is commanded.
struct DeltaAccuracy {
  double z_rms_mm = 0;       ///< Nozzle above bed, its mean included.
  double z_most_mm = 0;      ///< Largest magnitude of it.
  double z_flat_rms_mm = 0;  ///< Its mean left out.
  double xy_scale = 0;       ///< Moved over commanded, less 1, by least squares.
  double xy_rms_mm = 0;      ///< Of what is neither shift nor turn.
};

/// Exactly, at the points of a square lattice, an eighth of the radius wide, that lie
/// on the disc. Not numbers where the machine does not reach.
DeltaAccuracy DeltaAccuracyOf(const DeltaBuild<double>& build,
                              const DeltaBed<double>& bed,
                              const DeltaModel<double>& settings,
                              double radius_mm);

/// By how much other settings change the height at which the nozzle of a machine
/// stands, rms over the same points. Not a number where it does not reach.
double DeltaHeightChange_mm(const DeltaBuild<double>& build,
                            const DeltaModel<double>& from,
                            const DeltaModel<double>& to,
                            double radius_mm);

}  // namespace caltwin
