#pragma once

#include <span>

#include "calibration/estimate/uncertain.h"

namespace caltwin {

/// What blurs one touch: the scatter of the trigger, and that a controller reports
/// whole motor steps.
struct TouchNoise {
  double sigma_mm = 0;  ///< Of the trigger itself, before rounding.
  double step_mm = 0;   ///< Travel of one motor step; 0: not rounded.
};

/// Standard deviation of one touch: sqrt(sigma^2 + step^2 / 12).
double TouchSd_mm(const TouchNoise& noise);

/// Standard deviation of the mean of `count` touches of the same point.
///
/// Scatter averages out; rounding to steps does so only where the scatter shakes the
/// reading over several steps. Readings of one point share a rounding bias of variance
///
///   beta^2 = step^2 sum_k exp(-(2 pi k sigma / step)^2) / (2 pi^2 k^2)
///
/// (over points anywhere between two steps): step^2 / 12 without scatter, 1 % of that
/// with sigma = step / 3. So  var(mean) = beta^2 + (sigma^2 + step^2 / 12 - beta^2) /
/// n.
double MeanSd_mm(const TouchNoise& noise, int count);

/// Sample standard deviation (n - 1); 0 for fewer than two readings.
double Scatter(std::span<const double> readings);
double Mean(std::span<const double> readings);

/// Mean of repeated touches of one point with the uncertainty of MeanSd_mm; not
/// identifiable without readings.
Uncertain MeanTouch_mm(std::span<const double> readings_mm, const TouchNoise& noise);

/// The trigger's own scatter as the readings show it: pooled over groups of repeats,
/// each about its own mean, less the step's share. Not identifiable without repeats.
Uncertain TriggerScatter_mm(std::span<const std::span<const double>> groups_mm,
                            double step_mm);

}  // namespace caltwin
