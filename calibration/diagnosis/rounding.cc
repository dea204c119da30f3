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

}  // namespace caltwin
