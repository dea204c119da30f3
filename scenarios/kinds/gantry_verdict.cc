#include "scenarios/kinds/gantry_verdict.h"

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
const Estimate* LastEstimate(const GantryTruth& trial,
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

// Whether the firmware has taken something for it, perhaps to give it back later.
bool WasApplied(const GantryTruth& trial, const std::string& name) {
  const auto steps = StepsOf(trial.results, name);
  return std::ranges::find(steps, Verdict::kApplied, &Step::verdict) != steps.end();
}

// Every name that belongs into the table, in the catalog's order.
std::vector<std::string> NamesOf(const GantryTruth& trial, const Expectation& expect) {
  std::set<std::string> named;
  for (const Injected& injected : *trial.effects) {
    for (std::size_t i = 0; i < injected.values.size(); ++i) {
      named.insert(ParameterName(injected.effect, injected.axis, i));
    }
  }
  for (const std::string& name : SettingNames(trial.machine->kind)) {
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
  for (const std::string& name : AllParameterNames(trial.machine->kind)) {
    if (named.contains(name)) names.push_back(name);
  }
  return names;
}

ParameterResult MakeRow(const GantryTruth& trial, const std::string& name) {
  ParameterResult row{
      .name = name,
      .unit = std::string(FindParameter(name, trial.machine->kind)->unit)};
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
  row.believed = after;
  return row;
}

// Errors up to this are no reproach: the tolerance, else 3 sd of the last estimate.
double FloorOf(const GantryTruth& trial, const ParameterResult& row) {
  const Estimate* estimate = LastEstimate(trial, row.name);
  const double sd = estimate != nullptr && estimate->identifiable ? estimate->sd : 0;
  return row.tolerance.value_or(kSigmas * sd);
}

// Told, and wrong: beyond its tolerance, else beyond 4 of its own sd, else (a setting
// without an estimate) less than half of the error gone.
bool WasMissed(const GantryTruth& trial, const ParameterResult& row) {
  constexpr double kFarSigmas = 4;
  if (!row.error) return false;
  if (row.tolerance) return std::abs(*row.error) > *row.tolerance;
  if (row.sd) return std::abs(*row.error) > kFarSigmas * *row.sd;
  const auto before = SettingNamed(trial.before, row.name);
  const double was = before ? std::abs(*before - row.injected) : 0;
  return was > 0 && std::abs(*row.error) > was / 2;
}

bool Diverges(const GantryTruth& trial, const ParameterResult& row) {
  const double floor = FloorOf(trial, row);
  int grown = 0;
  for (const Step& step : StepsOf(trial.results, row.name)) {
    if (step.verdict != Verdict::kApplied) continue;
    const double before = std::abs(step.before - row.injected);
    const double after = std::abs(step.after - row.injected);
    if (after > before && after > floor) ++grown;
  }
  return grown >= 2;
}

// The machine read "no gap" where there is one.
bool ReadsZero(const GantryTruth& trial, const ParameterResult& row) {
  if (!row.name.starts_with("backlash.") || row.is_setting) return false;
  const Estimate* estimate = LastEstimate(trial, row.name);
  if (estimate == nullptr || !estimate->identifiable) return false;
  const double floor =
      std::max(kSigmas * estimate->sd, row.tolerance.value_or(kNoWorse_mm));
  return std::abs(estimate->value) <= floor && std::abs(*row.error) > floor;
}

// Whether the firmware was left believing something worse than before.
bool WasMadeWorse(const GantryTruth& trial, const ParameterResult& row) {
  const auto before = SettingNamed(trial.before, row.name);
  const auto after = SettingNamed(trial.after, row.name);
  if (!before || !WasApplied(trial, row.name)) return false;
  const double error_after = std::abs(*after - row.injected);
  return error_after > std::abs(*before - row.injected) &&
         error_after > FloorOf(trial, row);
}

}  // namespace

std::vector<ParameterResult> MakeTable(const GantryTruth& trial,
                                       const Expectation& expect) {
  std::vector<ParameterResult> table;
  for (const std::string& name : NamesOf(trial, expect)) {
    table.push_back(MakeRow(trial, name));
  }
  return table;
}

TrueEnd EndOfGantry(const GantryTruth& trial,
                    const std::vector<ParameterResult>& table) {
  const auto any = [&](bool (*holds)(const GantryTruth&, const ParameterResult&)) {
    return std::ranges::any_of(
        table, [&](const ParameterResult& row) { return holds(trial, row); });
  };
  const bool anything = std::ranges::any_of(
      table, [](const ParameterResult& row) { return row.error.has_value(); });
  return {.figure = TrueFigure{.before = trial.position_error_before_mm,
                               .after = trial.position_error_after_mm,
                               .noise = kNoWorse_mm},
          .grew_twice = any(Diverges),
          .told_wrong = !anything || any(WasMissed) || any(WasMadeWorse),
          .reads_zero = any(ReadsZero)};
}

}  // namespace caltwin
