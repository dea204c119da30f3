#include "scenarios/verdict_text.h"

#include <algorithm>
#include <array>
#include <string_view>

#include <fmt/format.h>

#include "sim/base/units.h"

namespace caltwin {
namespace {

struct OutcomeWords {
  std::string_view outcome;
  std::string_view says;
};
constexpr std::array kOutcomes = {
    OutcomeWords{"recovers",
                 "The calibration recovered what was hidden in the machine"},
    OutcomeWords{"misses", "The calibration ended off the truth"},
    OutcomeWords{"diverges", "The calibration made the machine worse"},
    OutcomeWords{"refused", "The calibration was refused"},
    OutcomeWords{"confounded", "The measurements cannot tell the causes apart"},
    OutcomeWords{"reads_zero", "The calibration read zero though the machine is off"},
    OutcomeWords{"no_trigger", "The probe found nothing where a surface was expected"},
    OutcomeWords{"collision", "The tool ran into something"},
    OutcomeWords{"alarm", "The controller stopped with an alarm"}};

std::string SaysOf(const std::string& outcome) {
  const auto* const found =
      std::ranges::find(kOutcomes, outcome, &OutcomeWords::outcome);
  return found == kOutcomes.end() ? fmt::format("The run ended as '{}'", outcome)
                                  : std::string(found->says);
}

// The first thing that did not come true; empty: all did.
std::string FirstMiss(const RunResult& result) {
  for (const CheckResult& check : result.checks) {
    if (check.passed) continue;
    return fmt::format("{}: expected {}, found {}.",
                       check.name,
                       check.expected,
                       check.found.empty() ? "nothing" : check.found);
  }
  for (const ParameterResult& row : result.parameters) {
    if (row.passed.value_or(true)) continue;
    if (!row.recovered) return fmt::format("{} was not recovered.", row.name);
    return fmt::format("{} is off by {:.3g} {}; {:.3g} is allowed.",
                       row.name,
                       row.error.value_or(0),
                       row.unit,
                       row.tolerance.value_or(0));
  }
  return "";
}

constexpr double kNoLength_mm = 1e-6;  // What arithmetic leaves of nought.

std::string LengthWords(double length_mm) {
  if (length_mm < kNoLength_mm) return "0 um";
  return length_mm < 1 ? fmt::format("{:.3g} um", UmFromMm(length_mm))
                       : fmt::format("{:.3g} mm", length_mm);
}

// What the machine gained or lost; empty where a run has no such figure.
std::string GainOf(const RunResult& result) {
  const double before_mm = result.position_error_before_p95_mm;
  const double after_mm = result.position_error_after_p95_mm;
  if (before_mm < kNoLength_mm && after_mm < kNoLength_mm) return "";
  return fmt::format(
      "{} {} now, {} before.",
      result.is_error_of_nozzle
          ? "Commanded to 0 over the middle of the bed, the nozzle is off by"
          : "95 of 100 places of the travel are reached within",
      LengthWords(after_mm),
      LengthWords(before_mm));
}

}  // namespace

std::pair<int, int> Score(const RunResult& result) {
  int passed = 0;
  int all = 0;
  for (const ParameterResult& row : result.parameters) {
    if (!row.passed) continue;
    ++all;
    passed += *row.passed ? 1 : 0;
  }
  for (const CheckResult& check : result.checks) {
    ++all;
    passed += check.passed ? 1 : 0;
  }
  return {passed, all};
}

RunVerdict VerdictOf(const RunResult& result) {
  const auto [passed, all] = Score(result);
  RunVerdict verdict;
  const bool is_usual = result.outcome == "recovers";
  const bool is_checked = std::ranges::any_of(
      result.parameters, [](const auto& row) { return row.passed.has_value(); });
  verdict.sentence = fmt::format(
      "{}{}: {} of {} expectations met.",
      is_usual && !is_checked ? "The run ended well" : SaysOf(result.outcome),
      is_usual        ? ""
      : result.passed ? ", as the scenario expects"
                      : ", which was not expected",
      passed,
      all);
  for (const std::string& cause : result.Causes()) {
    verdict.remarks.push_back(
        fmt::format("Why: {}{}", cause, cause.ends_with('.') ? "" : "."));
  }
  if (const std::string miss = FirstMiss(result); !miss.empty()) {
    verdict.remarks.push_back(miss);
  }
  if (const std::string gain = GainOf(result); !gain.empty()) {
    verdict.remarks.push_back(gain);
  }
  if (result.lost) {
    verdict.remarks.emplace_back("A process or link was lost on the way.");
  }
  if (result.interrupted) {
    verdict.remarks.emplace_back("Interrupted; what was done until then is shown.");
  }
  return verdict;
}

}  // namespace caltwin
