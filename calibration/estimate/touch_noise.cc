#include "calibration/estimate/touch_noise.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "sim/base/mutant.h"
#include "sim/base/require.h"

namespace caltwin {
namespace {

// Variance of rounding to a grid, for a value anywhere on it.
double RoundingVariance(double step_mm) {
  return step_mm * step_mm / Mutant("touch_noise_step_over_sqrt3", 12.0, 3.0);
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

}  // namespace

double TouchSd_mm(const TouchNoise& noise) {
  return std::sqrt(noise.sigma_mm * noise.sigma_mm + RoundingVariance(noise.step_mm));
}

double MeanSd_mm(const TouchNoise& noise, int count) {
  Require(count > 0, "a mean has readings");
  const double all = noise.sigma_mm * noise.sigma_mm + RoundingVariance(noise.step_mm);
  const double shared = std::min(all, SharedRoundingVariance(noise));
  const int averaged = Mutant("touch_noise_mean_as_single", count, 1);
  return std::sqrt(shared + (all - shared) / averaged);
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
  return std::sqrt(sum / Mutant("scatter_divides_by_n", count - 1, count));
}

Uncertain MeanTouch_mm(std::span<const double> readings_mm, const TouchNoise& noise) {
  if (readings_mm.empty()) return {};
  return {.value = Mean(readings_mm),
          .sd = MeanSd_mm(noise, static_cast<int>(readings_mm.size())),
          .identifiable = true};
}

Uncertain TriggerScatter_mm(std::span<const std::span<const double>> groups_mm,
                            double step_mm) {
  double squares = 0;
  double dof = 0;
  for (const std::span<const double> group : groups_mm) {
    if (group.size() < 2) continue;
    const auto own_dof = static_cast<double>(group.size() - 1);
    squares += own_dof * Scatter(group) * Scatter(group);
    dof += own_dof;
  }
  if (dof == 0) return {};
  const double variance = squares / dof;
  return {.value = std::sqrt(std::max(0.0, variance - RoundingVariance(step_mm))),
          .sd = std::sqrt(variance / (2 * dof)),
          .identifiable = true};
}

}  // namespace caltwin
