#include "calibration/diagnosis/rounding.h"

#include <cmath>

#include "sim/base/mutant.h"

namespace caltwin {

double RoundingSigma_mm(const Observed& observed, Eigen::Index i) {
  const auto stated = observed.header().settings.find(observed.row(i).settings);
  if (!observed.at(i).delta || stated == observed.header().settings.end()) return 0;
  double variance_mm2 = 0;
  for (int tower = 0; tower < kNumTowers; ++tower) {
    const auto steps = stated->second.steps_per_mm.find(TowerName(tower));
    if (steps == stated->second.steps_per_mm.end() || steps->second <= 0) continue;
    const double slope =
        observed.at(i).n.dot(observed.at(i).delta->by_knob.col(kEndstopKnob + tower));
    variance_mm2 += std::pow(slope / steps->second, 2) /
                    Mutant("delta_rounding_as_a_sigma", 12.0, 1.0);
  }
  return std::sqrt(variance_mm2);
}

double RoundedBy_mm(const Observed& observed, Eigen::Index i, Axis axis) {
  constexpr double kNothing_mm = 1e-9;
  const At& at = observed.at(i);
  const auto stated = observed.header().settings.find(observed.row(i).settings);
  const bool counts_axes = !observed.machine().delta && !observed.machine().triple_z;
  if (!counts_axes || at.kind != RowKind::kPosition ||
      stated == observed.header().settings.end()) {
    return 0;
  }
  const auto steps = stated->second.steps_per_mm.find(Name(axis));
  if (steps == stated->second.steps_per_mm.end() || steps->second <= 0) return 0;
  const double command_mm =
      observed.row(i).cmd_mm[static_cast<std::size_t>(Index(axis))];
  const double beyond_mm =
      std::round(command_mm * steps->second) / steps->second - command_mm;
  return std::abs(beyond_mm) > kNothing_mm ? beyond_mm : 0;
}

}  // namespace caltwin
