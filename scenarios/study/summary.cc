#include "scenarios/study/summary.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "scenarios/result_text.h"
#include "scenarios/study/adaptive.h"
#include "scenarios/study/aggregate.h"

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

  void Add(const ParameterResult& result) {
    ++trials;
    if (!result.error) return;
    errors.push_back(*result.error);
    if (!result.sd || !(*result.sd > 0)) return;
    ++with_sd;
    held += std::abs(*result.error) <= kTwoSided95 * *result.sd ? 1 : 0;
    variance_sum += *result.sd * *result.sd;
    square_sum += *result.error * *result.error;
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

  void Add(const TrialResult& result) {
    ++status[result.status];
    if (const std::string cause = CauseKey(result); !cause.empty()) ++causes[cause];
    by_error.emplace_back(Badness(result, is_of_plan), result.trial);
    if (result.HasFailed()) return;
    machine_time_s.push_back(result.machine_time_s);
    touches.push_back(result.touches);
    before_mm.push_back(result.position_error_before_mm);
    after_mm.push_back(result.position_error_after_mm);
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
                        .position_error_after_mm = QuantilesOf(after_mm)};
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

nlohmann::ordered_json JsonOf(const Quantiles& quantiles) {
  return {{"count", quantiles.count},
          {"mean", quantiles.mean},
          {"sd", quantiles.sd},
          {"q025", quantiles.q025},
          {"median", quantiles.median},
          {"q975", quantiles.q975}};
}

nlohmann::ordered_json JsonOf(const Rate& rate) {
  return {{"rate", rate.rate},
          {"ci95", {rate.low, rate.high}},
          {"hits", rate.hits},
          {"of", rate.cases}};
}

nlohmann::ordered_json JsonOf(const ParameterSummary& parameter) {
  nlohmann::ordered_json json{{"name", parameter.name},
                              {"unit", parameter.unit},
                              {"is_setting", parameter.is_setting},
                              {"identified", JsonOf(parameter.identified)},
                              {"error", JsonOf(parameter.error)}};
  if (!parameter.histogram.counts.empty()) {
    json["histogram"] = {{"low", parameter.histogram.low},
                         {"high", parameter.histogram.high},
                         {"counts", parameter.histogram.counts}};
  }
  if (parameter.coverage95.cases > 0) {
    json["coverage95"] = JsonOf(parameter.coverage95);
    json["mean_sd"] = parameter.mean_sd;
    json["rms_over_sd"] = parameter.rms_over_sd;
    json["gum_validation"] = {{"digits", parameter.gum.digits},
                              {"delta", parameter.gum.delta},
                              {"d_low", parameter.gum.d_low},
                              {"d_high", parameter.gum.d_high},
                              {"settled", parameter.gum.is_settled},
                              {"holds", nullptr}};
    if (parameter.gum.is_settled) {
      json["gum_validation"]["holds"] = parameter.gum.holds();
    }
  }
  return json;
}

std::string CoverageText(const ParameterSummary& parameter) {
  const Rate& coverage = parameter.coverage95;
  if (coverage.cases == 0) return "-";
  constexpr double kPercent = 100;
  return fmt::format("{:.1f} ({:.1f}-{:.1f})",
                     kPercent * coverage.rate,
                     kPercent * coverage.low,
                     kPercent * coverage.high);
}

std::string CaseText(const CaseSummary& summary, const Study& study) {
  std::string text = fmt::format("\n{}\n ", summary.name);
  for (const auto& [status, count] : summary.status) {
    text += fmt::format(" {} {}", status, count);
  }
  const auto& causes = summary.causes;
  const auto most =
      std::ranges::max_element(causes, {}, [](const auto& one) { return one.second; });
  text += fmt::format("; {:.0f} touches, {:.0f} s on the machine (medians)\n",
                      summary.touches.median,
                      summary.machine_time_s.median);
  if (most != causes.end()) {
    text += fmt::format("  most often ({}): {}\n", most->second, most->first);
  }
  if (!study.plan) {  // A plan sets nothing right.
    text += fmt::format(
        "  position error p95: median {:.4f} mm before, {:.4f} after (97.5 %: "
        "{:.4f})\n",
        summary.position_error_before_mm.median,
        summary.position_error_after_mm.median,
        summary.position_error_after_mm.q975);
  }
  text += fmt::format("  {:<28} {:<6} {:>9} {:>11} {:>11} {:>8} {:>19}\n",
                      "quantity",
                      "unit",
                      "told",
                      "mean error",
                      "sd",
                      "rms/sd",
                      "coverage95 %");
  for (const ParameterSummary& parameter : summary.parameters) {
    const bool has_sd = parameter.coverage95.cases > 0;
    const bool is_told = parameter.error.count > 0;
    text +=
        fmt::format("  {:<28} {:<6} {:>9} {:>11} {:>11} {:>8} {:>19}\n",
                    parameter.name,
                    parameter.unit,
                    parameter.identified.hits,
                    is_told ? Sensible(parameter.error.mean, parameter.error.sd) : "-",
                    is_told ? Sensible(parameter.error.sd, parameter.error.sd) : "-",
                    has_sd ? fmt::format("{:.3f}", parameter.rms_over_sd) : "-",
                    CoverageText(parameter));
  }
  if (!summary.worst.empty()) {
    text += "  worst: " + ReplayCommand(study, summary.worst.front()) + "\n";
  }
  return text;
}

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
  return quantiles;
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

nlohmann::ordered_json SummaryJson(const Study& study, const StudySummary& summary) {
  nlohmann::ordered_json cases = nlohmann::ordered_json::array();
  for (const CaseSummary& one : summary.cases) {
    nlohmann::ordered_json parameters = nlohmann::ordered_json::array();
    for (const ParameterSummary& parameter : one.parameters) {
      parameters.push_back(JsonOf(parameter));
    }
    nlohmann::ordered_json worst = nlohmann::ordered_json::array();
    for (const std::int64_t trial : one.worst) {
      worst.push_back({{"trial", trial}, {"command", ReplayCommand(study, trial)}});
    }
    cases.push_back({{"name", one.name},
                     {"scenario", one.scenario},
                     {"procedure", one.procedure},
                     {"status", one.status},
                     {"causes", one.causes},
                     {"machine_time_s", JsonOf(one.machine_time_s)},
                     {"touches", JsonOf(one.touches)},
                     {"position_error_before_mm", JsonOf(one.position_error_before_mm)},
                     {"position_error_after_mm", JsonOf(one.position_error_after_mm)},
                     {"parameters", parameters},
                     {"worst", worst}});
  }
  return {{"format", 1},
          {"about", study.about},
          {"version", CALTWIN_VERSION},
          {"fingerprint", study.Fingerprint()},
          {"fidelity", study.FidelityWord()},
          {"seed", study.seed},
          {"trials", study.trials},
          {"trials_done", summary.trials},
          {"cases", cases}};
}

std::string SummaryText(const Study& study, const StudySummary& summary) {
  std::string text = fmt::format("{}: {}\n{} of {} machines, {}, seed {}\n",
                                 study.file.string(),
                                 study.about,
                                 summary.trials,
                                 study.trials,
                                 study.FidelityWord(),
                                 study.seed);
  for (const CaseSummary& one : summary.cases) text += CaseText(one, study);
  return text;
}

std::string ReplayCommand(const Study& study, std::int64_t trial) {
  return fmt::format("caltwin study {} --trial {}", study.file.string(), trial);
}

}  // namespace caltwin
