#pragma once

#include <array>
#include <optional>

#include "sim/machine/kinds/delta/knobs.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {

/// The nozzle of a six-rod chain at given motor travels, kept for its derivatives.
class ClosedDelta {
 public:
  /// nullopt where the chain does not close. `start`: a pose near by, or nothing.
  static std::optional<ClosedDelta> At(const DeltaBuild<double>& build,
                                       const Vec3<double>& motors_mm,
                                       const DeltaPose<double>* start = nullptr);

  const DeltaPose<double>& pose() const { return closed_.pose; }

  /// d(along . nozzle) / d(knob), inside values, of the knobs that turn the machine
  /// itself (all of kDeltaKnobs but the bed's): the adjoint of the closed chain.
  ///
  ///   slope' lambda = (along, 0),  d = - lambda . dF
  std::array<double, kNumDeltaKnobs> Slopes(const Vec3<double>& along) const;

  /// Height over the bed with its derivatives by all knobs.
  double HeightOver(const DeltaBed<double>& bed,
                    std::array<double, kNumDeltaKnobs>* slopes) const;

 private:
  ClosedDelta(const DeltaBuild<double>& build,
              const Vec3<double>& motors_mm,
              const delta_chain::Closed& closed)
      : build_(&build), motors_mm_(motors_mm), closed_(closed) {}

  const DeltaBuild<double>* build_;
  Vec3<double> motors_mm_;
  delta_chain::Closed closed_;
};

}  // namespace caltwin
