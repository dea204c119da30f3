#include "scenarios/study/summary.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "scenarios/study/adaptive.h"
#include "scenarios/study/aggregate.h"
#include "scenarios/study/error_moments.h"

namespace caltwin {
namespace {

constexpr double kTwoSided95 = 1.959963984540054;  // Of a normal distribution.
constexpr std::size_t kWorst = 5;

double Quantile(const std::vector<double>& sorted, double p) {
  const double at = p * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return std::lerp(sorted[below], sorted[above], at - static_cast<double>(below));
}

// What is collected of one parameter while the trials go by.
struct Collected {
  std::string unit{};
  bool is_setting = false;
  std::size_t position = 0;  ///< First seen as the so-manyth.
  std::vector<double> errors{};
  std::int64_t trials = 0, with_sd = 0, held = 0;
  double variance_sum = 0, square_sum = 0;  ///< Where an sd was stated.
  StatedMean stated{};                      ///< Sums of it.

  void Add(const ParameterResult& result) {
    ++trials;
    if (!result.error) return;
    errors.push_back(*result.error);
    if (!result.sd || !(*result.sd > 0)) return;
    ++with_sd;
    held += std::abs(*result.error) <= kTwoSided95 * *result.sd ? 1 : 0;
    variance_sum += *result.sd * *result.sd;
    square_sum += *result.error * *result.error;
    const double u2 = std::pow(CombinedOf(result)->u, 2);
    stated.square_u += u2;
    stated.fourth_u += u2 * u2;
    stated.fourth_u_per_dof += u2 * u2 / CombinedOf(result)->dof;
  }

  ParameterSummary Summary(const std::string& name) const {
    ParameterSummary summary{
        .name = name,
        .unit = unit,
        .is_setting = is_setting,
        .error = QuantilesOf(errors),
        .identified = RateOf(static_cast<std::int64_t>(errors.size()), trials),
        .coverage95 = RateOf(held, with_sd)};
    summary.histogram = EmptyHistogram(summary.error);
    for (const double error : errors) CountIn(error, 1, &summary.histogram);
    if (with_sd > 0) {
      const auto count = static_cast<double>(with_sd);
      summary.mean_sd = std::sqrt(variance_sum / count);
      summary.rms_over_sd = std::sqrt(square_sum / variance_sum);
      StatedMean mean = stated;
      mean.square_u /= count;
      summary.stated = ExpandedOf(mean, summary.mean_sd);
      summary.gum = ValidationOf(summary.error, summary.mean_sd, /*digits=*/1);
    }
    return summary;
  }
};

struct CollectedCase {
  bool is_of_plan = false;
  std::map<std::string, std::int64_t> status{}, causes{};
  std::vector<double> machine_time_s{}, touches{}, before_mm{}, after_mm{};
  std::vector<std::pair<double, std::int64_t>> by_error{};  ///< By Badness.
  std::map<std::string, Collected> parameters{};
  ErrorMoments moments{};

  void Add(const TrialResult& result) {
    ++status[result.status];
    if (const std::string cause = CauseKey(result); !cause.empty()) ++causes[cause];
    by_error.emplace_back(Badness(result, is_of_plan), result.trial);
    if (result.HasFailed()) return;
    machine_time_s.push_back(result.machine_time_s);
    touches.push_back(result.touches);
    before_mm.push_back(result.position_error_before_mm);
    after_mm.push_back(result.position_error_after_mm);
    moments.Add(result);
    for (const ParameterResult& parameter : result.parameters) {
      const auto [it, is_new] = parameters.try_emplace(parameter.name);
      if (is_new) {
        it->second.unit = parameter.unit;
        it->second.is_setting = parameter.is_setting;
        it->second.position = parameters.size();
      }
      it->second.Add(parameter);
    }
  }

  CaseSummary Summary(const StudyCase& of) {
    CaseSummary summary{.name = of.Name(),
                        .scenario = of.scenario.file.string(),
                        .procedure = of.procedure,
                        .status = status,
                        .causes = causes,
                        .machine_time_s = QuantilesOf(machine_time_s),
                        .touches = QuantilesOf(touches),
                        .position_error_before_mm = QuantilesOf(before_mm),
                        .position_error_after_mm = QuantilesOf(after_mm),
                        .correlations = moments.Result(),
                        .correlated_trials = moments.least_trials()};
    std::vector<std::pair<std::size_t, ParameterSummary>> ordered;
    for (const auto& [name, collected] : parameters) {
      ordered.emplace_back(collected.position, collected.Summary(name));
    }
    std::ranges::sort(ordered, {}, [](const auto& one) { return one.first; });
    for (auto& [position, one] : ordered) summary.parameters.push_back(std::move(one));
    std::ranges::sort(by_error, [](const auto& one, const auto& other) {
      return one.first != other.first ? one.first > other.first
                                      : one.second < other.second;
    });
    for (std::size_t i = 0; i < std::min(kWorst, by_error.size()); ++i) {
      summary.worst.push_back(by_error[i].second);
    }
    return summary;
  }
};

}  // namespace

Quantiles QuantilesOf(std::vector<double> values) {
  Quantiles quantiles{.count = static_cast<std::int64_t>(values.size())};
  if (values.empty()) return quantiles;
  std::ranges::sort(values);
  const auto count = static_cast<double>(values.size());
  quantiles.mean = std::accumulate(values.begin(), values.end(), 0.0) / count;
  double square = 0;
  for (const double value : values) square += std::pow(value - quantiles.mean, 2);
  quantiles.sd = values.size() > 1 ? std::sqrt(square / (count - 1)) : 0;
  quantiles.q025 = Quantile(values, 0.025);
  quantiles.median = Quantile(values, 0.5);
  quantiles.q975 = Quantile(values, 0.975);
  SetShortest([&](double p) { return Quantile(values, p); }, &quantiles);
  return quantiles;
}

void SetShortest(const std::function<double(double p)>& quantile,
                 Quantiles* quantiles) {
  constexpr double kHeld = 0.95;
  constexpr int kSteps = 200;  // Of what may lie below: a four-thousandth each.
  double shortest = std::numeric_limits<double>::infinity();
  // From the middle outwards, so that of equally short ones the symmetric counts.
  for (int i = 0; i <= kSteps; ++i) {
    const int at = kSteps / 2 + (i % 2 == 0 ? i / 2 : -(i + 1) / 2);
    const double below = (1 - kHeld) * at / kSteps;
    const double low = quantile(below), high = quantile(below + kHeld);
    if (!(high - low < shortest)) continue;
    shortest = high - low;
    quantiles->shortest_low = low;
    quantiles->shortest_high = high;
  }
}

Validation ValidationOf(const Quantiles& error, double stated_sd, int digits) {
  // Standard error of the 2.5 % quantile of n normal values, in standard deviations:
  // sqrt(0.025 0.975 / n) over the density there, 0.0584.
  constexpr double kQuantileError = 2.671;
  Validation validation{.digits = digits,
                        .delta = NumericalTolerance(error.sd, digits)};
  validation.d_low = std::abs(-kTwoSided95 * stated_sd - error.q025);
  validation.d_high = std::abs(kTwoSided95 * stated_sd - error.q975);
  const double standard_error =
      kQuantileError * error.sd / std::sqrt(static_cast<double>(error.count));
  validation.is_settled = 2 * standard_error <= validation.delta / 5;
  return validation;
}

Expanded ExpandedOf(const StatedMean& mean, double mean_sd) {
  Expanded stated{.u = mean.square_u > 0 ? std::sqrt(mean.square_u) : mean_sd,
                  .U = kTwoSided95 * mean_sd};
  stated.k = stated.U / stated.u;
  if (mean.fourth_u_per_dof > 0) stated.dof = mean.fourth_u / mean.fourth_u_per_dof;
  return stated;
}

Histogram EmptyHistogram(const Quantiles& errors) {
  constexpr std::size_t kParts = 41;  // Odd: one of them is about 0.
  constexpr double kSigmas = 4;
  if (errors.count == 0 || !(errors.sd > 0)) return {};
  const double half = std::abs(errors.mean) + kSigmas * errors.sd;
  return {.low = -half, .high = half, .counts = std::vector<std::int64_t>(kParts)};
}

void CountIn(double value, std::int64_t count, Histogram* histogram) {
  if (histogram->counts.empty()) return;
  const auto parts = static_cast<double>(histogram->counts.size());
  const double at =
      (value - histogram->low) / (histogram->high - histogram->low) * parts;
  histogram->counts[static_cast<std::size_t>(std::clamp(at, 0.0, parts - 1))] += count;
}

Rate RateOf(std::int64_t hits, std::int64_t cases) {
  Rate rate{.hits = hits, .cases = cases};
  if (cases == 0) return rate;
  const auto n = static_cast<double>(cases);
  const double p = static_cast<double>(hits) / n, z2 = kTwoSided95 * kTwoSided95;
  const double middle = (p + z2 / (2 * n)) / (1 + z2 / n);
  const double half =
      kTwoSided95 * std::sqrt(p * (1 - p) / n + z2 / (4 * n * n)) / (1 + z2 / n);
  rate.rate = p;
  rate.low = std::max(0.0, middle - half);
  rate.high = std::min(1.0, middle + half);
  return rate;
}

double Badness(const TrialResult& result, bool is_of_plan) {
  if (result.HasFailed()) return -1;
  if (!is_of_plan) return result.position_error_after_mm;
  double largest_sd = 0;
  for (const ParameterResult& parameter : result.parameters) {
    if (!parameter.error || !parameter.sd || !(*parameter.sd > 0)) continue;
    largest_sd = std::max(largest_sd, std::abs(*parameter.error) / *parameter.sd);
  }
  return largest_sd;
}

std::string CauseKey(const TrialResult& result) {
  if (result.message.empty()) return "";
  std::string key = result.status + ": ";
  for (const char c : result.message) {
    const bool is_digit = c >= '0' && c <= '9';
    if (!is_digit) key += c;
    if (is_digit && !key.ends_with('#')) key += '#';
  }
  return key;
}

namespace {

// One pass over what is kept.
template <typename Of>
StudySummary Collect(const Study& study, const StudyStore& store) {
  std::vector<Of> collected(study.cases.size(), Of{study.plan != nullptr});
  StudySummary summary;
  std::size_t of_trial = 0;  // Cases come one after the other.
  std::int64_t trial = -1;
  store.ForEach([&](const TrialResult& result) {
    collected.at(result.of_case).Add(result);
    of_trial = result.trial == trial ? of_trial + 1 : 1;
    trial = result.trial;
    summary.trials += of_trial == study.cases.size() ? 1 : 0;
  });
  for (std::size_t i = 0; i < study.cases.size(); ++i) {
    summary.cases.push_back(collected[i].Summary(study.cases[i]));
  }
  return summary;
}

}  // namespace

StudySummary SummaryOf(const Study& study, const StudyStore& store) {
  constexpr std::int64_t kMostExact = 200'000;  // A dozen errors each: 20 MB.
  return study.trials > kMostExact ? Collect<Aggregate>(study, store)
                                   : Collect<CollectedCase>(study, store);
}

}  // namespace caltwin
