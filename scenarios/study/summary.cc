#include "scenarios/study/summary.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "scenarios/result_text.h"

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
    if (with_sd > 0) {
      const auto count = static_cast<double>(with_sd);
      summary.mean_sd = std::sqrt(variance_sum / count);
      summary.rms_over_sd = std::sqrt(square_sum / variance_sum);
    }
    return summary;
  }
};

struct CollectedCase {
  std::map<std::string, std::int64_t> status{};
  std::vector<double> machine_time_s{}, touches{}, before_mm{}, after_mm{};
  std::vector<std::pair<double, std::int64_t>> by_error{};  ///< Failed: infinite.
  std::map<std::string, Collected> parameters{};

  void Add(const TrialResult& result) {
    ++status[result.status];
    const bool has_failed = !result.message.empty();
    by_error.emplace_back(has_failed ? -1 : result.position_error_after_mm,
                          result.trial);
    if (has_failed) return;
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
  if (parameter.coverage95.cases > 0) {
    json["coverage95"] = JsonOf(parameter.coverage95);
    json["mean_sd"] = parameter.mean_sd;
    json["rms_over_sd"] = parameter.rms_over_sd;
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
  text += fmt::format(
      "; {:.0f} touches, {:.0f} s on the machine (medians)\n  position error p95: "
      "median "
      "{:.4f} mm before, {:.4f} after (97.5 %: {:.4f})\n",
      summary.touches.median,
      summary.machine_time_s.median,
      summary.position_error_before_mm.median,
      summary.position_error_after_mm.median,
      summary.position_error_after_mm.q975);
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
    text += fmt::format("  {:<28} {:<6} {:>9} {:>11} {:>11} {:>8} {:>19}\n",
                        parameter.name,
                        parameter.unit,
                        parameter.identified.hits,
                        Sensible(parameter.error.mean, parameter.error.sd),
                        Sensible(parameter.error.sd, parameter.error.sd),
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

StudySummary SummaryOf(const Study& study, const StudyStore& store) {
  std::vector<CollectedCase> collected(study.cases.size());
  std::map<std::int64_t, std::size_t> done;
  store.ForEach([&](const TrialResult& result) {
    collected.at(result.of_case).Add(result);
    ++done[result.trial];
  });
  StudySummary summary;
  for (const auto& [trial, cases] : done) {
    summary.trials += cases == study.cases.size() ? 1 : 0;
  }
  for (std::size_t i = 0; i < study.cases.size(); ++i) {
    summary.cases.push_back(collected[i].Summary(study.cases[i]));
  }
  return summary;
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
          {"fidelity", ToString(study.fidelity)},
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
                                 ToString(study.fidelity),
                                 study.seed);
  for (const CaseSummary& one : summary.cases) text += CaseText(one, study);
  return text;
}

std::string TrialsCsv(const Study& study, const StudyStore& store) {
  std::set<std::string> names;
  store.ForEach([&](const TrialResult& result) {
    for (const ParameterResult& parameter : result.parameters) {
      names.insert(parameter.name);
    }
  });
  std::string csv = "trial,seed,status,machine_time_s,touches";
  for (const std::string& name : names) {
    csv += fmt::format(",{0}.injected,{0}.recovered,{0}.sd", name);
  }
  const bool has_cases = study.cases.size() > 1;
  csv += has_cases ? ",case\n" : "\n";
  const auto cell = [](const std::optional<double>& value) {
    return value ? fmt::format("{}", *value) : std::string();
  };
  store.ForEach([&](const TrialResult& result) {
    csv += fmt::format("{},{},{},{},{}",
                       result.trial,
                       study.seed,
                       result.status,
                       result.machine_time_s,
                       result.touches);
    std::map<std::string, const ParameterResult*> by_name;
    for (const ParameterResult& parameter : result.parameters) {
      by_name[parameter.name] = &parameter;
    }
    for (const std::string& name : names) {
      const auto found = by_name.find(name);
      if (found == by_name.end()) {
        csv += ",,,";
        continue;
      }
      const ParameterResult& parameter = *found->second;
      csv += fmt::format(",{},{},{}",
                         parameter.injected,
                         cell(parameter.recovered),
                         cell(parameter.sd));
    }
    csv += has_cases ? fmt::format(",{}\n", study.cases[result.of_case].Name()) : "\n";
  });
  return csv;
}

std::string ReplayCommand(const Study& study, std::int64_t trial) {
  return fmt::format("caltwin study {} --trial {}", study.file.string(), trial);
}

}  // namespace caltwin
