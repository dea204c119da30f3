#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "scenarios/study/store.h"

namespace caltwin {

/// 2.5, 50 and 97.5 % quantiles by linear interpolation between order statistics (type
/// 7 of Hyndman and Fan), mean and standard deviation.
struct Quantiles {
  std::int64_t count = 0;
  double mean = 0, sd = 0;
  double q025 = 0, median = 0, q975 = 0;
};
Quantiles QuantilesOf(std::vector<double> values);

/// How often what was so many times of so many, with Wilson's 95 % interval.
struct Rate {
  std::int64_t hits = 0, cases = 0;
  double rate = 0, low = 0, high = 1;
};
Rate RateOf(std::int64_t hits, std::int64_t cases);

/// What a contender's estimates of one parameter were worth.
struct ParameterSummary {
  std::string name{}, unit{};
  bool is_setting = false;
  Quantiles error{};       ///< recovered - injected, where something was told.
  Rate identified{};       ///< Told something, of all trials that were run.
  Rate coverage95{};       ///< Truth within recovered +- 1.96 sd, where sd was stated.
  double mean_sd = 0;      ///< Root of the mean of the stated variances.
  double rms_over_sd = 0;  ///< Root mean square error over it: 1 where honest.
};

struct CaseSummary {
  std::string name{}, scenario{}, procedure{};
  std::map<std::string, std::int64_t> status{};
  Quantiles machine_time_s{}, touches{};
  Quantiles position_error_before_mm{}, position_error_after_mm{};
  std::vector<ParameterSummary> parameters{};
  /// Trials with the largest position error left, the worst first; then failed ones.
  std::vector<std::int64_t> worst{};
};

struct StudySummary {
  std::int64_t trials = 0;  ///< Done by every contender.
  std::vector<CaseSummary> cases{};
};

StudySummary SummaryOf(const Study& study, const StudyStore& store);

/// `summary.json`.
nlohmann::ordered_json SummaryJson(const Study& study, const StudySummary& summary);
/// What the terminal shows.
std::string SummaryText(const Study& study, const StudySummary& summary);

/// `trials.csv`: a line a trial and contender, in their order; the same bytes whoever
/// ran them in whatever order.
std::string TrialsCsv(const Study& study, const StudyStore& store);

/// What runs one trial again.
std::string ReplayCommand(const Study& study, std::int64_t trial);

}  // namespace caltwin
