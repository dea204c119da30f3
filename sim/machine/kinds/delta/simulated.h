#pragma once

#include "sim/base/rng.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/kinds/delta/touch.h"

namespace caltwin {

/// A delta in closed form that can be touched: built so, over this bed, its trigger
/// scattering along z.
class SimulatedDelta {
 public:
  SimulatedDelta(const DeltaBuild<double>& build,
                 const DeltaBed<double>& bed,
                 double sigma_mm,
                 std::uint64_t seed)
      : build_(build), bed_(bed), sigma_mm_(sigma_mm), rng_(seed, 0, "delta.touch") {}

  /// The motors' commanded travels when the probe triggers on the way straight down at
  /// (x, y), as the firmware believing `settings` counts them. nullopt: out of reach.
  std::optional<Vec3<double>> Touch(const DeltaModel<double>& settings,
                                    double x_mm,
                                    double y_mm) {
    const auto motors_mm = DeltaTouchMotors(build_, bed_, settings, x_mm, y_mm);
    if (!motors_mm || sigma_mm_ == 0) return motors_mm;
    Vec3<double> at = DeltaNozzle_mm(settings, *motors_mm);
    at[2] += sigma_mm_ * rng_.Normal();
    return DeltaMotors_mm(settings, at);
  }

  const DeltaBuild<double>& build() const { return build_; }
  const DeltaBed<double>& bed() const { return bed_; }

 private:
  DeltaBuild<double> build_;
  DeltaBed<double> bed_;
  double sigma_mm_ = 0;
  Rng rng_;
};

}  // namespace caltwin
