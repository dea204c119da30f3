#pragma once

#include <span>

#include "calibration/estimate/uncertain.h"

namespace caltwin {

/// Scatter of one cluster [mm] above which NeXT 3.5 suspects the mechanics.
inline constexpr double kScatterWarning_mm = 0.005;

/// Two groups of readings of one feature, by the sense of approach, and whether they
/// are one.
struct ClusterStatistics {
  double mean_plus_mm = 0;
  double mean_minus_mm = 0;
  double scatter_plus_mm = 0;  ///< Sample standard deviation (n - 1).
  double scatter_minus_mm = 0;
  double scatter_all_mm = 0;  ///< Of all readings, whatever their sense.
  int count_plus = 0;
  int count_minus = 0;
  bool scatter_warning = false;  ///< A cluster scatters by more than 5 um.
  /// Probability of a gap at least as large, were there none: two-sided Student test
  /// with pooled variance, which is never taken below that of rounding, step^2 / 12.
  double p_value = 1;
  bool one_cluster = true;  ///< p_value is at least 1 %.
  /// The seed's own test: all readings scatter by less than 5 um. Passes with a gap
  /// below 10 um, and fails on scatter alone.
  bool one_cluster_as_published = true;
  bool identifiable = false;  ///< Both clusters have at least two readings.
};

ClusterStatistics CompareClusters(std::span<const double> plus_mm,
                                  std::span<const double> minus_mm,
                                  double step_mm);

/// |mean+ - mean-|: NeXT 3.5 step 3, whatever the readings are of. What that distance
/// is depends on how they were taken: PROCEDURES and docs say when it is not backlash.
Uncertain ClusterGapAsPublished(std::span<const double> plus_mm,
                                std::span<const double> minus_mm,
                                double step_mm);

/// Probability that Student's t with `dof` degrees of freedom is farther from 0 than
/// `t`, either side. Exact series for whole dof (Abramowitz and Stegun 26.7.3, 26.7.4).
double StudentTwoSided(double t, int dof);

}  // namespace caltwin
