#include "scenarios/verdict.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scenarios/parameter_name.h"
#include "sim/effects/injected.h"

namespace caltwin {
namespace {

constexpr double kSigmas = 3;
constexpr double kNoWorse_mm = 0.001;

// The last identifiable estimate of a name, else the last; of those that became a
// setting, or of all.
const Estimate* LastEstimate(const Trial& trial,
                             const std::string& name,
                             bool settings_only = false) {
  const Estimate* last = nullptr;
  for (const ProcedureResult& result : trial.results) {
    for (const Estimate& estimate : result.estimates) {
      if (estimate.name != name || (settings_only && !estimate.is_setting)) continue;
      if (last != nullptr && last->identifiable && !estimate.identifiable) continue;
      last = &estimate;
    }
  }
  return last;
}

std::vector<Step> StepsOf(const Trial& trial, const std::string& name) {
  std::vector<Step> steps;
  for (const ProcedureResult& result : trial.results) {
    for (const Step& step : result.steps) {
      if (step.name == name) steps.push_back(step);
    }
  }
  return steps;
}

// Whether the firmware has taken something for it, perhaps to give it back later.
bool WasApplied(const Trial& trial, const std::string& name) {
  const auto steps = StepsOf(trial, name);
  return std::ranges::find(steps, Verdict::kApplied, &Step::verdict) != steps.end();
}

const ParameterExpectation* ExpectationOf(const Expectation& expect,
                                          const std::string& name) {
  const auto found =
      std::ranges::find(expect.parameters, name, &ParameterExpectation::name);
  return found == expect.parameters.end() ? nullptr : &*found;
}

// Every name that belongs into the table, in the catalog's order.
std::vector<std::string> NamesOf(const Trial& trial, const Expectation& expect) {
  std::set<std::string> named;
  for (const Injected& injected : *trial.effects) {
    for (std::size_t i = 0; i < injected.values.size(); ++i) {
      named.insert(ParameterName(injected.effect, injected.axis, i));
    }
  }
  for (const std::string& name : SettingNames()) {
    const bool is_wrong =
        SettingNamed(trial.before, name) != SettingNamed(trial.machine->settings, name);
    if (is_wrong) named.insert(name);
  }
  for (const ProcedureResult& result : trial.results) {
    for (const Estimate& estimate : result.estimates) named.insert(estimate.name);
    for (const Step& step : result.steps) named.insert(step.name);
  }
  for (const ParameterExpectation& p : expect.parameters) named.insert(p.name);
  std::vector<std::string> names;
  for (const std::string& name : AllParameterNames()) {
    if (named.contains(name)) names.push_back(name);
  }
  return names;
}

bool Holds(const ParameterExpectation& expected, const ParameterResult& row) {
  if (expected.truth_within) {
    if (!row.error || !(std::abs(*row.error) <= *expected.truth_within)) return false;
  }
  return !expected.identifiable || *expected.identifiable == row.identifiable;
}

ParameterResult MakeRow(const Trial& trial,
                        const std::string& name,
                        const ParameterExpectation* expected) {
  ParameterResult row{.name = name, .unit = std::string(FindParameter(name)->unit)};
  row.injected = *BuiltValueNamed(*trial.machine, *trial.effects, name);
  const auto before = SettingNamed(trial.before, name);
  const auto after = SettingNamed(trial.after, name);
  const Estimate* estimate = LastEstimate(trial, name);
  const Estimate* setting = LastEstimate(trial, name, true);
  const bool only_measured =
      estimate != nullptr && estimate->identifiable && !WasApplied(trial, name);
  row.is_setting = after.has_value() && !only_measured;
  if (row.is_setting && setting != nullptr) estimate = setting;
  if (estimate != nullptr) {
    row.identifiable = estimate->identifiable;
    if (row.identifiable) {
      row.sd = estimate->sd;
      row.budget = estimate->budget;
    }
    if (row.identifiable) row.recovered = row.is_setting ? *after : estimate->value;
  } else if (after && *before != *after) {
    row.identifiable = true;
    row.recovered = after;
  }
  if (row.recovered) row.error = *row.recovered - row.injected;
  if (expected != nullptr) {
    row.tolerance = expected->truth_within;
    if (expected->truth_within || expected->identifiable) {
      row.passed = Holds(*expected, row);
    }
  }
  return row;
}

// Errors up to this are no reproach: the tolerance, else 3 sd of the last estimate.
double FloorOf(const Trial& trial, const ParameterResult& row) {
  const Estimate* estimate = LastEstimate(trial, row.name);
  const double sd = estimate != nullptr && estimate->identifiable ? estimate->sd : 0;
  return row.tolerance.value_or(kSigmas * sd);
}

// Told, and wrong: beyond its tolerance, else beyond 4 of its own sd, else (a setting
// without an estimate) less than half of the error gone.
bool WasMissed(const Trial& trial, const ParameterResult& row) {
  constexpr double kFarSigmas = 4;
  if (!row.error) return false;
  if (row.tolerance) return std::abs(*row.error) > *row.tolerance;
  if (row.sd) return std::abs(*row.error) > kFarSigmas * *row.sd;
  const auto before = SettingNamed(trial.before, row.name);
  const double was = before ? std::abs(*before - row.injected) : 0;
  return was > 0 && std::abs(*row.error) > was / 2;
}

bool Diverges(const Trial& trial, const ParameterResult& row) {
  const double floor = FloorOf(trial, row);
  int grown = 0;
  for (const Step& step : StepsOf(trial, row.name)) {
    if (step.verdict != Verdict::kApplied) continue;
    const double before = std::abs(step.before - row.injected);
    const double after = std::abs(step.after - row.injected);
    if (after > before && after > floor) ++grown;
  }
  return grown >= 2;
}

// The machine read "no gap" where there is one.
bool ReadsZero(const Trial& trial, const ParameterResult& row) {
  if (!row.name.starts_with("backlash.") || row.is_setting) return false;
  const Estimate* estimate = LastEstimate(trial, row.name);
  if (estimate == nullptr || !estimate->identifiable) return false;
  const double floor =
      std::max(kSigmas * estimate->sd, row.tolerance.value_or(kNoWorse_mm));
  return std::abs(estimate->value) <= floor && std::abs(*row.error) > floor;
}

// Whether the firmware was left believing something worse than before.
bool WasMadeWorse(const Trial& trial, const ParameterResult& row) {
  const auto before = SettingNamed(trial.before, row.name);
  const auto after = SettingNamed(trial.after, row.name);
  if (!before || !WasApplied(trial, row.name)) return false;
  const double error_after = std::abs(*after - row.injected);
  return error_after > std::abs(*before - row.injected) &&
         error_after > FloorOf(trial, row);
}

bool AnyEnded(const Trial& trial, Ending ending) {
  return std::ranges::any_of(trial.results, [&](const ProcedureResult& result) {
    return result.ending == ending;
  });
}

bool AnythingApplied(const Trial& trial) {
  for (const ProcedureResult& result : trial.results) {
    for (const Step& step : result.steps) {
      if (step.verdict == Verdict::kApplied) return true;
    }
  }
  return false;
}

void Add(std::vector<CheckResult>* checks,
         const std::string& name,
         const std::string& expected,
         const std::string& found,
         bool passed) {
  checks->push_back(
      {.name = name, .expected = expected, .found = found, .passed = passed});
}

std::string OrNone(const std::optional<double>& value) {
  return value ? fmt::format("{:.6g}", *value) : "none";
}

void CheckSteps(const Trial& trial,
                const ParameterExpectation& expected,
                std::vector<CheckResult>* checks) {
  std::vector<double> after;
  for (const Step& step : StepsOf(trial, expected.name)) after.push_back(step.after);
  bool passed = after.size() >= expected.steps.size();
  for (std::size_t i = 0; passed && i < expected.steps.size(); ++i) {
    passed = std::abs(after[i] - expected.steps[i]) <= expected.steps_within;
  }
  Add(checks,
      expected.name + ".steps",
      fmt::format("{:.6g}, each within {:.3g}",
                  fmt::join(expected.steps, ", "),
                  expected.steps_within),
      fmt::format("{:.6g}", fmt::join(after, ", ")),
      passed);
}

void CheckParameter(const Trial& trial,
                    const ParameterExpectation& expected,
                    const ParameterResult& row,
                    std::vector<CheckResult>* checks) {
  const auto words = [](bool flag) {
    return flag ? "identifiable" : "cannot be told";
  };
  if (expected.identifiable) {
    Add(checks,
        expected.name + ".identifiable",
        words(*expected.identifiable),
        words(row.identifiable),
        *expected.identifiable == row.identifiable);
  }
  if (expected.sd_below) {
    Add(checks,
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
    Add(checks,
        expected.name + ".truth_within_sd",
        fmt::format("error at most {:.3g} sd", *expected.truth_within_sd),
        OrNone(in_sd),
        in_sd && *in_sd <= *expected.truth_within_sd);
  }
  if (expected.reads) {
    // What nobody has looked at reads as the firmware believes it.
    const auto reads =
        row.recovered ? row.recovered : SettingNamed(trial.after, row.name);
    Add(checks,
        expected.name + ".reads",
        fmt::format(
            "{:.6g} within {:.3g}", expected.reads->value, expected.reads->within),
        OrNone(reads),
        reads && std::abs(*reads - expected.reads->value) <= expected.reads->within);
  }
  if (!expected.steps.empty()) CheckSteps(trial, expected, checks);
}

bool AnyMessageSays(const Trial& trial, const std::string& text) {
  for (const ProcedureResult& result : trial.results) {
    const auto says = [&](const std::string& message) {
      return message.find(text) != std::string::npos;
    };
    if (std::ranges::any_of(result.messages, says)) return true;
    if (std::ranges::any_of(result.steps, says, &Step::message)) return true;
    if (std::ranges::any_of(result.observability, says, &Observability::statement)) {
      return true;
    }
    if (says(result.fault)) return true;
  }
  return false;
}

}  // namespace

std::vector<ParameterResult> MakeTable(const Trial& trial, const Expectation& expect) {
  std::vector<ParameterResult> table;
  for (const std::string& name : NamesOf(trial, expect)) {
    table.push_back(MakeRow(trial, name, ExpectationOf(expect, name)));
  }
  return table;
}

std::string JudgeOutcome(const Trial& trial,
                         const std::vector<ParameterResult>& table) {
  const auto diverges = [&](const ParameterResult& row) {
    return Diverges(trial, row);
  };
  if (std::ranges::any_of(table, diverges)) return "diverges";
  if (AnyEnded(trial, Ending::kAlarm)) return "alarm";
  if (AnyEnded(trial, Ending::kCollision)) return "collision";
  if (AnyEnded(trial, Ending::kNoTrigger)) return "no_trigger";
  if (AnyEnded(trial, Ending::kRefused) && !AnythingApplied(trial)) return "refused";
  const auto zero = [&](const ParameterResult& row) {
    return ReadsZero(trial, row);
  };
  if (AnyEnded(trial, Ending::kReadsZero) || std::ranges::any_of(table, zero)) {
    return "reads_zero";
  }
  if (AnyEnded(trial, Ending::kConfounded)) return "confounded";
  const bool missed = std::ranges::any_of(table, [&](const ParameterResult& row) {
    return (row.tolerance && row.passed == false) || WasMissed(trial, row) ||
           WasMadeWorse(trial, row);
  });
  const bool anything = std::ranges::any_of(
      table, [&](const ParameterResult& row) { return row.error.has_value(); });
  const double growth_mm =
      trial.position_error_after_mm - trial.position_error_before_mm;
  if (missed || !anything || growth_mm > kNoWorse_mm) return "misses";
  return "recovers";
}

std::vector<CheckResult> MakeChecks(const Trial& trial,
                                    const Expectation& expect,
                                    const std::vector<ParameterResult>& table,
                                    const std::string& outcome) {
  std::vector<CheckResult> checks;
  Add(&checks, "outcome", expect.outcome, outcome, outcome == expect.outcome);
  for (const ParameterExpectation& expected : expect.parameters) {
    const auto row = std::ranges::find(table, expected.name, &ParameterResult::name);
    CheckParameter(trial, expected, *row, &checks);
  }
  if (expect.position_error_below_mm) {
    Add(&checks,
        "position_error_mm.p95",
        fmt::format("below {:.4g} mm", *expect.position_error_below_mm),
        fmt::format("{:.4g} mm", trial.position_error_after_mm),
        trial.position_error_after_mm < *expect.position_error_below_mm);
  }
  for (const std::string& text : expect.messages) {
    const bool found = AnyMessageSays(trial, text);
    Add(&checks, "message", text, found ? "said" : "not said", found);
  }
  return checks;
}

}  // namespace caltwin
