#pragma once

#include <limits>
#include <span>

#include "calibration/estimate/uncertain.h"

namespace caltwin {

/// What blurs one touch: the scatter of the trigger, and that a controller reports
/// whole motor steps.
struct TouchNoise {
  double sigma_mm = 0;  ///< Of the trigger itself, before rounding.
  double step_mm = 0;   ///< Travel of one motor step; 0: not rounded.
  /// What sigma was told by: repeats (NoiseSeen, which widens it by t / 1.96), or
  /// somebody's statement.
  double dof = std::numeric_limits<double>::infinity();
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

/// The noise to reckon with after groups of repeats, each scattering about its own
/// mean: the one stated, unless they contradict it.
///
/// They do where their pooled variance of nu degrees of freedom exceeds the one stated,
/// sigma^2 + step^2 / 12 less the rounding they share, by more than chance does once in
/// a thousand (Wilson and Hilferty's chi2: (1 - 2 / (9 nu) + 3.09 sqrt(2 / (9 nu)))^3).
/// Then it takes the place of what was stated, widened by t(nu) / 1.96, so that +-1.96
/// sd hold 95 % in small samples too. The larger of both would be too wide on average:
/// scatter exceeds its own expectation every second time.
TouchNoise NoiseSeen(const TouchNoise& stated,
                     std::span<const std::span<const double>> groups_mm);

/// Student's t / 1.96: what a standard deviation told by `dof` degrees of freedom is
/// multiplied by for an interval of +-1.96 to hold 95 %.
double SmallSampleFactor(int dof);

/// What a sample standard deviation is multiplied by for its own uncertainty, so that
/// +-1.96 of it hold the true one 95 % of the time: near 1 / sqrt(2 dof), more in small
/// samples, whose standard deviation is oftener too small than too large (chi2 by
/// Wilson and Hilferty; normal readings).
double ScatterSdFactor(int dof);

/// What the standard deviations of a least-squares fit are to be multiplied by: 1,
/// unless its residuals contradict the noise stated (chi2 per dof beyond what chance
/// makes of so many degrees of freedom once in a thousand, as in NoiseSeen). Then
/// sqrt(chi2_per_dof) t(dof) / 1.96: the residuals' own scatter, for intervals of
/// +-1.96 sd. Where nobody stated a noise (`is_stated` false) the residuals are
/// believed in any case, and what the fit was weighed with is the least of it.
double ScatterFactor(double chi2_per_dof, int dof, bool is_stated = true);

/// The trigger's own scatter as the readings show it: pooled over groups of repeats,
/// each about its own mean, less the step's share. Not identifiable without repeats.
Uncertain TriggerScatter_mm(std::span<const std::span<const double>> groups_mm,
                            double step_mm);

}  // namespace caltwin
