// A summary as it is written down: `summary.json`, and the terminal's table.

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "scenarios/result_text.h"
#include "scenarios/study/best_readings.h"
#include "scenarios/study/summary.h"

namespace caltwin {
namespace {

nlohmann::ordered_json JsonOf(const Quantiles& quantiles) {
  return {{"count", quantiles.count},
          {"mean", quantiles.mean},
          {"sd", quantiles.sd},
          {"q025", quantiles.q025},
          {"median", quantiles.median},
          {"q975", quantiles.q975},
          {"shortest95", {quantiles.shortest_low, quantiles.shortest_high}}};
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
    json["uncertainty"] = {{"u", parameter.stated.u},
                           {"k", parameter.stated.k},
                           {"U", parameter.stated.U},
                           {"dof", nullptr}};
    if (std::isfinite(parameter.stated.dof)) {
      json["uncertainty"]["dof"] = parameter.stated.dof;
    }
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

std::string GoTogetherText(const CaseSummary& summary) {
  constexpr std::size_t kMost = 3;
  std::string text;
  for (const CorrelatedPair& pair : PairsBeyondChance(summary, kMost)) {
    text += fmt::format("{} {} with {} {:+.2f}",
                        text.empty() ? "errors go together:" : ",",
                        pair.first,
                        pair.second,
                        pair.r);
  }
  return text;
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
  text +=
      fmt::format("  {:<28} {:<6} {:>9} {:>11} {:>11} {:>9} {:>5} {:>5} {:>7} {:>19}\n",
                  "quantity",
                  "unit",
                  "told",
                  "mean error",
                  "sd",
                  "U",
                  "k",
                  "dof",
                  "rms/sd",
                  "coverage95 %");
  for (const ParameterSummary& parameter : summary.parameters) {
    const bool has_sd = parameter.coverage95.cases > 0;
    const bool is_told = parameter.error.count > 0;
    const Expanded& stated = parameter.stated;
    text += fmt::format(
        "  {:<28} {:<6} {:>9} {:>11} {:>11} {:>9} {:>5} {:>5} {:>7} {:>19}\n",
        parameter.name,
        parameter.unit,
        parameter.identified.hits,
        is_told ? Sensible(parameter.error.mean, parameter.error.sd) : "-",
        is_told ? Sensible(parameter.error.sd, parameter.error.sd) : "-",
        has_sd ? Sensible(stated.U, stated.U) : "-",
        has_sd ? fmt::format("{:.2f}", stated.k) : "-",
        has_sd ? DofText(stated.dof) : "-",
        has_sd ? fmt::format("{:.3f}", parameter.rms_over_sd) : "-",
        CoverageText(parameter));
  }
  if (const std::string pairs = GoTogetherText(summary); !pairs.empty()) {
    text += "  " + pairs + "\n";
  }
  if (!summary.worst.empty()) {
    text += "  worst: " + ReplayCommand(study, summary.worst.front()) + "\n";
  }
  return text;
}

}  // namespace

std::vector<CorrelatedPair> PairsBeyondChance(const CaseSummary& summary,
                                              std::size_t most) {
  constexpr double kWorthSaying = 0.3, kBeyondChance = 5;
  if (summary.correlations.names.empty()) return {};
  const auto trials = static_cast<double>(summary.correlated_trials);
  const double least = std::max(kWorthSaying, kBeyondChance / std::sqrt(trials));
  return LargestPairs(summary.correlations, most, least);
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
                     {"correlations", ToJson(one.correlations)},
                     {"worst", worst}});
  }
  nlohmann::ordered_json plan;
  if (study.plan) plan = ToJson(*study.plan, WorthOf(*study.plan));
  return {{"format", 1},
          {"about", study.about},
          {"notes", study.notes},
          {"plan", plan},
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
  for (const std::string& note : study.notes) text += note + "\n";
  for (const CaseSummary& one : summary.cases) text += CaseText(one, study);
  return text;
}

std::string ReplayCommand(const Study& study, std::int64_t trial) {
  return fmt::format("caltwin study {} --trial {}", study.file.string(), trial);
}

}  // namespace caltwin
