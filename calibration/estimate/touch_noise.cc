#include "calibration/estimate/touch_noise.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "calibration/estimate/clusters.h"
#include "sim/base/require.h"

namespace caltwin {
namespace {

// Variance of rounding to a grid, for a value anywhere on it.
double RoundingVariance(double step_mm) {
  return step_mm * step_mm / 12.0;
}

double SharedRoundingVariance(const TouchNoise& noise) {
  if (noise.step_mm == 0) return 0;
  const double ratio = 2 * std::numbers::pi * noise.sigma_mm / noise.step_mm;
  // Less scatter than a sixth of a percent of a step shakes nothing: all is shared.
  if (ratio < 0.01) return RoundingVariance(noise.step_mm);
  double sum = 0;
  for (double k = 1; k * ratio < 6; ++k) {  // exp(-36) ends it.
    sum += std::exp(-k * ratio * k * ratio) / (k * k);
  }
  return noise.step_mm * noise.step_mm * sum /
         (2 * std::numbers::pi * std::numbers::pi);
}

// Variance within groups of repeats, each about its own mean.
struct Pooled {
  double variance_mm2 = 0;
  int dof = 0;
};

Pooled PooledOver(std::span<const std::span<const double>> groups_mm) {
  Pooled pooled;
  double squares = 0;
  for (const std::span<const double> group : groups_mm) {
    if (group.size() < 2) continue;
    const int own_dof = static_cast<int>(group.size()) - 1;
    squares += own_dof * Scatter(group) * Scatter(group);
    pooled.dof += own_dof;
  }
  if (pooled.dof > 0) pooled.variance_mm2 = squares / pooled.dof;
  return pooled;
}

// What chance lets a variance of so many degrees of freedom be, over its expectation,
// once in a thousand.
double LargestByChance(int dof) {
  constexpr double kOnceInAThousand = 3.09;  // Of a normal distribution, one side.
  const double spread = 2 / (9.0 * dof);
  return std::pow(1 - spread + kOnceInAThousand * std::sqrt(spread), 3);
}

}  // namespace

double TouchSd_mm(const TouchNoise& noise) {
  return std::sqrt(noise.sigma_mm * noise.sigma_mm + RoundingVariance(noise.step_mm));
}

double MeanSd_mm(const TouchNoise& noise, int count) {
  Require(count > 0, "a mean has readings");
  const double all = noise.sigma_mm * noise.sigma_mm + RoundingVariance(noise.step_mm);
  const double shared = std::min(all, SharedRoundingVariance(noise));
  return std::sqrt(shared + (all - shared) / count);
}

double Mean(std::span<const double> readings) {
  if (readings.empty()) return 0;
  return std::accumulate(readings.begin(), readings.end(), 0.0) /
         static_cast<double>(readings.size());
}

double Scatter(std::span<const double> readings) {
  if (readings.size() < 2) return 0;
  const double mean = Mean(readings);
  double sum = 0;
  for (const double reading : readings) sum += (reading - mean) * (reading - mean);
  const auto count = static_cast<double>(readings.size());
  return std::sqrt(sum / (count - 1));
}

Uncertain MeanTouch_mm(std::span<const double> readings_mm, const TouchNoise& noise) {
  if (readings_mm.empty()) return {};
  return {.value = Mean(readings_mm),
          .sd = MeanSd_mm(noise, static_cast<int>(readings_mm.size())),
          .identifiable = true};
}

double SmallSampleFactor(int dof) {
  constexpr double kNormal95 = 1.959963984540054;
  double low = kNormal95, high = 13;  // t of one degree of freedom is 12.7.
  while (high - low > 1e-9) {
    const double middle = (low + high) / 2;
    (StudentTwoSided(middle, dof) > 0.05 ? low : high) = middle;
  }
  return high / kNormal95;
}

double ScatterSdFactor(int dof) {
  Require(dof > 0, "a scatter has degrees of freedom");
  // P(chi2 / dof < x) as of a normal variable.
  const auto below = [dof](double x) {
    const double spread = 2 / (9.0 * dof);
    const double z = (std::cbrt(x) - 1 + spread) / std::sqrt(spread);
    return std::erfc(-z / std::numbers::sqrt2) / 2;
  };
  // sigma lies within (1 +- h) s where chi2 / dof lies within 1 / (1 +- h)^2.
  const auto misses = [&](double h) {
    const double too_small = below(1 / ((1 + h) * (1 + h)));
    return h < 1 ? too_small + 1 - below(1 / ((1 - h) * (1 - h))) : too_small;
  };
  double low = 0, high = 100;
  while (high - low > 1e-9) {
    const double middle = (low + high) / 2;
    (misses(middle) > 0.05 ? low : high) = middle;
  }
  return high / 1.959963984540054;
}

double ScatterFactor(double chi2_per_dof, int dof, bool is_stated) {
  if (dof < 1 || (is_stated && chi2_per_dof <= LargestByChance(dof))) return 1;
  return std::max(1.0, std::sqrt(chi2_per_dof) * SmallSampleFactor(dof));
}

TouchNoise NoiseSeen(const TouchNoise& stated,
                     std::span<const std::span<const double>> groups_mm) {
  const Pooled pooled = PooledOver(groups_mm);
  if (pooled.dof == 0) return stated;
  const double rounding_mm2 = RoundingVariance(stated.step_mm);
  const double expected_mm2 =
      std::max(0.0,
               stated.sigma_mm * stated.sigma_mm + rounding_mm2 -
                   SharedRoundingVariance(stated));
  const double largest_mm2 = expected_mm2 * LargestByChance(pooled.dof);
  if (pooled.variance_mm2 <= largest_mm2) {
    return stated;
  }
  const double sigma_mm = std::sqrt(std::max(0.0, pooled.variance_mm2 - rounding_mm2));
  return {
      .sigma_mm = std::max(stated.sigma_mm, sigma_mm * SmallSampleFactor(pooled.dof)),
      .step_mm = stated.step_mm,
      .dof = static_cast<double>(pooled.dof)};
}

Uncertain TriggerScatter_mm(std::span<const std::span<const double>> groups_mm,
                            double step_mm) {
  const Pooled pooled = PooledOver(groups_mm);
  if (pooled.dof == 0) return {};
  return {.value =
              std::sqrt(std::max(0.0, pooled.variance_mm2 - RoundingVariance(step_mm))),
          .sd = std::sqrt(pooled.variance_mm2 / (2.0 * pooled.dof)),
          .identifiable = true};
}

}  // namespace caltwin
