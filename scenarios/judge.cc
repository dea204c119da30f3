#include "scenarios/judge.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace caltwin {
namespace {

ParameterResult* RowNamed(const std::string& name, RunResult* result) {
  const auto row = std::ranges::find(result->parameters, name, &ParameterResult::name);
  return row == result->parameters.end() ? nullptr : &*row;
}

bool Holds(const ParameterExpectation& expected, const ParameterResult& row) {
  if (expected.truth_within) {
    if (!row.error || !(std::abs(*row.error) <= *expected.truth_within)) return false;
  }
  return !expected.identifiable || *expected.identifiable == row.identifiable;
}

bool AnyEnded(const std::vector<ProcedureResult>& results, Ending ending) {
  return std::ranges::find(results, ending, &ProcedureResult::ending) != results.end();
}

void Add(RunResult* result,
         const std::string& name,
         const std::string& expected,
         const std::string& found,
         bool passed) {
  result->checks.push_back(
      {.name = name, .expected = expected, .found = found, .passed = passed});
}

std::string OrNone(const std::optional<double>& value) {
  return value ? fmt::format("{:.6g}", *value) : "none";
}

void CheckSteps(const ParameterExpectation& expected,
                const std::vector<ProcedureResult>& results,
                RunResult* result) {
  std::vector<double> after;
  for (const Step& step : StepsOf(results, expected.name)) after.push_back(step.after);
  bool passed = after.size() >= expected.steps.size();
  for (std::size_t i = 0; passed && i < expected.steps.size(); ++i) {
    passed = std::abs(after[i] - expected.steps[i]) <= expected.steps_within;
  }
  Add(result,
      expected.name + ".steps",
      fmt::format("{:.6g}, each within {:.3g}",
                  fmt::join(expected.steps, ", "),
                  expected.steps_within),
      fmt::format("{:.6g}", fmt::join(after, ", ")),
      passed);
}

// What nobody has looked at reads as the firmware believes it.
std::optional<double> ReadingOf(const ParameterResult& row) {
  return row.recovered ? row.recovered : row.believed;
}

void CheckParameter(const ParameterExpectation& expected,
                    const ParameterResult& row,
                    RunResult* result) {
  if (expected.identifiable) {
    const auto words = [](bool flag) {
      return flag ? "identifiable" : "cannot be told";
    };
    Add(result,
        expected.name + ".identifiable",
        words(*expected.identifiable),
        words(row.identifiable),
        *expected.identifiable == row.identifiable);
  }
  if (expected.sd_below) {
    Add(result,
        expected.name + ".sd_below",
        fmt::format("below {:.3g} {}", *expected.sd_below, row.unit),
        OrNone(row.sd),
        row.sd && *row.sd < *expected.sd_below);
  }
  if (expected.truth_within_sd) {
    const std::optional<double> in_sd =
        row.error && row.sd && *row.sd > 0
            ? std::optional(std::abs(*row.error) / *row.sd)
            : std::nullopt;
    Add(result,
        expected.name + ".truth_within_sd",
        fmt::format("error at most {:.3g} sd", *expected.truth_within_sd),
        OrNone(in_sd),
        in_sd && *in_sd <= *expected.truth_within_sd);
  }
  if (expected.reads) {
    const auto reads = ReadingOf(row);
    Add(result,
        expected.name + ".reads",
        fmt::format(
            "{:.6g} within {:.3g}", expected.reads->value, expected.reads->within),
        OrNone(reads),
        reads && std::abs(*reads - expected.reads->value) <= expected.reads->within);
  }
}

bool IsSaid(const std::string& text,
            const std::vector<ProcedureResult>& results,
            const RunResult& result) {
  const auto says = [&](const std::string& message) {
    return message.find(text) != std::string::npos;
  };
  if (std::ranges::any_of(result.messages, says, &Message::text)) return true;
  return std::ranges::any_of(results, [&](const ProcedureResult& part) {
    return says(part.fault) ||
           std::ranges::any_of(part.messages, says, &Message::text) ||
           std::ranges::any_of(part.steps, says, &Step::message) ||
           std::ranges::any_of(part.observability, says, &Observability::statement);
  });
}

}  // namespace

std::vector<Step> StepsOf(const std::vector<ProcedureResult>& results,
                          const std::string& name) {
  std::vector<Step> steps;
  for (const ProcedureResult& result : results) {
    for (const Step& step : result.steps) {
      if (step.name == name) steps.push_back(step);
    }
  }
  return steps;
}

bool MeetExpectations(const Expectation& expect, RunResult* result) {
  bool all_met = true;
  for (const ParameterExpectation& expected : expect.parameters) {
    ParameterResult* const row = RowNamed(expected.name, result);
    if (row == nullptr) {
      const bool wants_none = expected.identifiable == false;
      Add(result,
          expected.name,
          wants_none ? "no value" : "a value",
          "not estimated",
          wants_none);
      all_met = all_met && wants_none;
      continue;
    }
    row->tolerance = expected.truth_within;
    if (!expected.truth_within && !expected.identifiable) continue;
    row->passed = Holds(expected, *row);
    all_met = all_met && *row->passed;
  }
  return all_met;
}

std::string JudgeOutcome(const std::vector<ProcedureResult>& results,
                         const TrueEnd& end,
                         bool all_met) {
  if (end.grew_twice) return "diverges";
  if (AnyEnded(results, Ending::kAlarm)) return "alarm";
  if (AnyEnded(results, Ending::kCollision)) return "collision";
  if (AnyEnded(results, Ending::kNoTrigger)) return "no_trigger";
  if (!results.empty() && results.back().ending == Ending::kRefused) return "refused";
  if (AnyEnded(results, Ending::kReadsZero) || end.reads_zero) return "reads_zero";
  if (AnyEnded(results, Ending::kConfounded)) return "confounded";
  const auto& figure = end.figure;
  // A machine that reaches nothing any more has no figure: that is worse too.
  if (figure && !(figure->after <= figure->before + figure->noise)) return "diverges";
  if (!all_met || end.told_wrong || (figure && !figure->is_met)) return "misses";
  return "recovers";
}

void CheckParameters(const Expectation& expect,
                     const std::vector<ProcedureResult>& results,
                     RunResult* result) {
  for (const ParameterExpectation& expected : expect.parameters) {
    const ParameterResult* const row = RowNamed(expected.name, result);
    if (row != nullptr) CheckParameter(expected, *row, result);
    if (!expected.steps.empty()) CheckSteps(expected, results, result);
  }
}

void CheckFigure(const FigureExpectation& expected, double found, RunResult* result) {
  const Within& within = expected.within;
  std::string bounds;
  if (within.above) bounds += fmt::format("above {:g}", *within.above);
  if (within.below) {
    bounds += fmt::format("{}below {:g}", bounds.empty() ? "" : ", ", *within.below);
  }
  Add(result,
      expected.name,
      bounds,
      fmt::format("{:.6g}", found),
      (!within.above || found > *within.above) &&
          (!within.below || found < *within.below));
}

void CheckMessages(const std::vector<std::string>& texts,
                   const std::vector<ProcedureResult>& results,
                   RunResult* result) {
  for (const std::string& text : texts) {
    const bool is_there = IsSaid(text, results, *result);
    Add(result, "message", text, is_there ? "said" : "not said", is_there);
  }
}

void CheckOutcome(const std::string& expected, RunResult* result) {
  result->checks.insert(result->checks.begin(),
                        {.name = "outcome",
                         .expected = expected,
                         .found = result->outcome,
                         .passed = result->outcome == expected});
}

bool AllPassed(const RunResult& result) {
  const bool all_parameters = std::ranges::none_of(
      result.parameters,
      [](const ParameterResult& row) { return row.passed == false; });
  return std::ranges::all_of(result.checks, &CheckResult::passed) && all_parameters &&
         !result.lost && !result.interrupted;
}

}  // namespace caltwin
