#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "calibration/estimate/correlation.h"
#include "calibration/estimate/expanded.h"
#include "scenarios/study/store.h"

namespace caltwin {

/// 2.5, 50 and 97.5 % quantiles by linear interpolation between order statistics (type
/// 7 of Hyndman and Fan), mean and standard deviation.
struct Quantiles {
  std::int64_t count = 0;
  double mean = 0, sd = 0;
  double q025 = 0, median = 0, q975 = 0;
  /// The shortest interval that holds 95 % (JCGM 101, 7.7.4).
  double shortest_low = 0, shortest_high = 0;
};
Quantiles QuantilesOf(std::vector<double> values);
/// Sets the shortest interval, by the value below which a share p lies.
void SetShortest(const std::function<double(double p)>& quantile, Quantiles* quantiles);

/// Counts in parts of one width, those beyond the ends in the last ones.
struct Histogram {
  double low = 0, high = 0;
  std::vector<std::int64_t> counts{};
};
/// The ends for errors of that mean and sd: about 0, four sd beyond the mean.
Histogram EmptyHistogram(const Quantiles& errors);
/// Counts `count` values as that one.
void CountIn(double value, std::int64_t count, Histogram* histogram);

/// How often what was so many times of so many, with Wilson's 95 % interval.
struct Rate {
  std::int64_t hits = 0, cases = 0;
  double rate = 0, low = 0, high = 1;
};
Rate RateOf(std::int64_t hits, std::int64_t cases);

/// JCGM 101 section 8: whether the first-order result, 0 +- 1.96 times the stated
/// standard deviation, is the interval that the trials show, within the tolerance of
/// `digits` significant digits of u.
struct Validation {
  int digits = 1;
  double delta = 0;              ///< NumericalTolerance of u.
  double d_low = 0, d_high = 0;  ///< Ends of both intervals, apart.
  /// The trials themselves know the ends to delta / 5 (twice their standard error).
  bool is_settled = false;
  bool holds() const { return d_low <= delta && d_high <= delta; }
};
Validation ValidationOf(const Quantiles& error, double stated_sd, int digits);

/// U, u, k and degrees of freedom as trials state them, taken together: roots of the
/// mean squares of U = 1.96 sd and of u, k = U / u, and
///
///   nu = sum u^4 / sum (u^4 / nu_i)
///
/// which is each trial's where all are alike, infinite where all are.
struct StatedMean {
  double square_u = 0;  ///< Mean of u^2; 0: nothing was taken apart, u is sd.
  double fourth_u = 0;  ///< Sum of u^4.
  double fourth_u_per_dof = 0;
};
Expanded ExpandedOf(const StatedMean& mean, double mean_sd);

/// What a contender's estimates of one parameter were worth.
struct ParameterSummary {
  std::string name{}, unit{};
  bool is_setting = false;
  Quantiles error{};       ///< recovered - injected, where something was told.
  Histogram histogram{};   ///< Of the same.
  Rate identified{};       ///< Told something, of all trials that were run.
  Rate coverage95{};       ///< Truth within recovered +- 1.96 sd, where sd was stated.
  double mean_sd = 0;      ///< Root of the mean of the stated variances.
  double rms_over_sd = 0;  ///< Root mean square error over it: 1 where honest.
  Expanded stated{};       ///< Where sd was stated; StatedMean of the trials'.
  Validation gum{};        ///< Where sd was stated; of one digit.
};

struct CaseSummary {
  std::string name{}, scenario{}, procedure{};
  std::map<std::string, std::int64_t> status{};
  /// Trials by "status: why", its numbers as #; of those that say why.
  std::map<std::string, std::int64_t> causes{};
  Quantiles machine_time_s{}, touches{};
  Quantiles position_error_before_mm{}, position_error_after_mm{};
  std::vector<ParameterSummary> parameters{};
  /// Of errors over the trials (ErrorMoments); without names where too few tell them,
  /// or more trials are kept than memory holds.
  Correlations correlations{};
  std::int64_t correlated_trials = 0;  ///< That tell the pair of which fewest do.
  /// The worst first, by Badness.
  std::vector<std::int64_t> worst{};
};

struct StudySummary {
  std::int64_t trials = 0;  ///< Done by every contender.
  std::vector<CaseSummary> cases{};
};

/// By which trials are ranked: the position error left; of a plan, which sets nothing
/// right, the largest error over its stated sd; -1 of those that could not be run.
double Badness(const TrialResult& result, bool is_of_plan);

/// "no_trigger: Probe failed at # mm": the same for all trials of one cause; empty
/// where the trial says none.
std::string CauseKey(const TrialResult& result);

/// Of what is kept. Quantiles are exact up to 200 000 trials, beyond that right to
/// 1/256 of themselves, so that memory does not grow.
StudySummary SummaryOf(const Study& study, const StudyStore& store);

/// The largest correlations of errors, of those of 0.3 and more that chance (five
/// standard deviations, 5 / sqrt(trials)) does not make.
std::vector<CorrelatedPair> PairsBeyondChance(const CaseSummary& summary,
                                              std::size_t most);

/// `summary.json`.
nlohmann::ordered_json SummaryJson(const Study& study, const StudySummary& summary);
/// What the terminal shows.
std::string SummaryText(const Study& study, const StudySummary& summary);

/// What runs one trial again.
std::string ReplayCommand(const Study& study, std::int64_t trial);

}  // namespace caltwin
