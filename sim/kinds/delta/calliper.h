#pragma once

#include <optional>

#include "sim/base/rng.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {

/// A person's calliper on a simulated delta: reads its rods and what it printed, each
/// reading off by chance.
class SimulatedDeltaCalliper {
 public:
  SimulatedDeltaCalliper(const DeltaBuild<double>& build,
                         double sigma_mm,
                         std::uint64_t seed,
                         std::uint64_t sample)
      : build_(build), sigma_mm_(sigma_mm), scatter_(seed, sample, "calliper") {}

  /// Any length.
  double Read_mm(double true_mm) { return true_mm + sigma_mm_ * scatter_.Normal(); }
  /// The length of a rod, joint to joint.
  double Rod_mm(int rod);
  /// The distance of two features of a print, drawn with the motors at these commanded
  /// travels. nullopt: the machine does not reach there.
  std::optional<double> Between_mm(const Vec3<double>& from_mm,
                                   const Vec3<double>& to_mm);

 private:
  DeltaBuild<double> build_;
  double sigma_mm_;
  Rng scatter_;
};

}  // namespace caltwin
