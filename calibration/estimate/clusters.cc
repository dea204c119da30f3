#include "calibration/estimate/clusters.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "calibration/estimate/touch_noise.h"
#include "sim/base/require.h"

namespace caltwin {
namespace {

constexpr double kSignificance = 0.01;

// Variance of one reading, pooled over both clusters, and of the difference of means.
struct Pooled {
  double reading_mm2 = 0;
  double difference_mm2 = 0;
  int dof = 0;
};

Pooled PooledVariance(std::span<const double> plus_mm,
                      std::span<const double> minus_mm,
                      double step_mm) {
  const auto n_plus = static_cast<double>(plus_mm.size());
  const auto n_minus = static_cast<double>(minus_mm.size());
  const double squares = (n_plus - 1) * std::pow(Scatter(plus_mm), 2) +
                         (n_minus - 1) * std::pow(Scatter(minus_mm), 2);
  Pooled pooled{.dof = static_cast<int>(plus_mm.size() + minus_mm.size()) - 2};
  // Readings that all fall on one step have no scatter, but are not exact.
  pooled.reading_mm2 = std::max(squares / pooled.dof, step_mm * step_mm / 12);
  pooled.difference_mm2 = pooled.reading_mm2 * (1 / n_plus + 1 / n_minus);
  return pooled;
}

}  // namespace

double StudentTwoSided(double t, int dof) {
  Require(dof >= 1, "at least one degree of freedom");
  const double theta = std::atan(std::abs(t) / std::sqrt(dof));
  const double cos2 = std::pow(std::cos(theta), 2);
  if (dof == 1) return 1 - 2 * theta / std::numbers::pi;

  const bool odd = dof % 2 == 1;
  double term = odd ? std::cos(theta) : 1;
  double sum = 0;
  for (int k = odd ? 3 : 2; k <= dof; k += 2) {
    sum += term;
    term *= cos2 * (k - 1) / k;
  }
  const double inside = odd ? (theta + std::sin(theta) * sum) * 2 / std::numbers::pi
                            : std::sin(theta) * sum;
  return std::max(0.0, 1 - inside);
}

ClusterStatistics CompareClusters(std::span<const double> plus_mm,
                                  std::span<const double> minus_mm,
                                  double step_mm) {
  std::vector<double> all(plus_mm.begin(), plus_mm.end());
  all.insert(all.end(), minus_mm.begin(), minus_mm.end());

  ClusterStatistics statistics{.mean_plus_mm = Mean(plus_mm),
                               .mean_minus_mm = Mean(minus_mm),
                               .scatter_plus_mm = Scatter(plus_mm),
                               .scatter_minus_mm = Scatter(minus_mm),
                               .scatter_all_mm = Scatter(all),
                               .count_plus = static_cast<int>(plus_mm.size()),
                               .count_minus = static_cast<int>(minus_mm.size())};
  statistics.scatter_warning =
      std::max(statistics.scatter_plus_mm, statistics.scatter_minus_mm) >
      kScatterWarning_mm;
  statistics.one_cluster_as_published = statistics.scatter_all_mm < kScatterWarning_mm;
  statistics.identifiable = plus_mm.size() >= 2 && minus_mm.size() >= 2;
  if (!statistics.identifiable) return statistics;

  const Pooled pooled = PooledVariance(plus_mm, minus_mm, step_mm);
  const double gap_mm = statistics.mean_plus_mm - statistics.mean_minus_mm;
  if (pooled.difference_mm2 > 0) {
    const double t = gap_mm / std::sqrt(pooled.difference_mm2);
    statistics.p_value = StudentTwoSided(t, pooled.dof);
  } else {
    statistics.p_value = gap_mm == 0 ? 1 : 0;
  }
  statistics.one_cluster = statistics.p_value >= kSignificance;
  return statistics;
}

Uncertain ClusterGapAsPublished(std::span<const double> plus_mm,
                                std::span<const double> minus_mm,
                                double step_mm) {
  if (plus_mm.size() < 2 || minus_mm.size() < 2) return {};
  return {.value = std::abs(Mean(plus_mm) - Mean(minus_mm)),
          .sd = std::sqrt(PooledVariance(plus_mm, minus_mm, step_mm).difference_mm2),
          .identifiable = true};
}

}  // namespace caltwin
