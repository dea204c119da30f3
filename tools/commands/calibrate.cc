#include "tools/commands/calibrate.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iostream>

#include <fmt/format.h>

#include "calibration/estimate/shared_inputs.h"
#include "scenarios/interrupt.h"
#include "scenarios/result_text.h"
#include "sim/base/input_error.h"
#include "tools/commands/command.h"
#include "tools/commands/spare_files.h"
#include "tools/commands/terminal.h"
#include "tools/commands/twin_options.h"

namespace caltwin {

bool IsTwin(const CalibrateOptions& options) {
  return options.link.starts_with("twin:");
}

std::optional<MachineFile> MachineToCalibrate(const CalibrateOptions& options) {
  const bool is_twin = IsTwin(options);
  const std::string machine =
      is_twin ? TwinOptionsOf(options.link).machine : options.machine;
  if (machine.empty()) return std::nullopt;
  return ReadAnyMachineFile(
      FindMachine(machine, "", {.file = is_twin ? machine : "--machine"}));
}

std::string ProceduresText(const CalibrateOptions& options, const Procedures& known) {
  std::string text = "calibrate:\n";
  for (const std::string& procedure : options.procedures) {
    const bool is_plain = procedure.find(':') == std::string::npos;
    std::string keys;
    if (is_plain && !options.axis.empty()) {
      const Procedure* const named = FindProcedure(procedure, known);
      keys += named != nullptr && named->takes_axes
                  ? fmt::format("axes: [{}]", options.axis)
                  : fmt::format("axis: {}", options.axis);
    }
    if (is_plain && !options.variant.empty()) {
      keys += fmt::format("{}variant: {}", keys.empty() ? "" : ", ", options.variant);
    }
    text += is_plain ? fmt::format("  - {}: {{{}}}\n", procedure, keys)
                     : fmt::format("  - {}\n", procedure);
  }
  return text;
}

void RefuseScenarioSteps(const std::vector<CalibrationStep>& steps,
                         const KindScenario& kind) {
  for (const CalibrationStep& step : steps) {
    const bool is_of_scenarios =
        step.external || step.perform ||
        std::ranges::any_of(kind.ScenarioSteps(),
                            [&](const Word& word) { return word.name == step.name; });
    if (!is_of_scenarios) continue;
    throw InputError({.file = "--procedure"},
                     step.name + " is a step of scenarios only",
                     "write a scenario and `caltwin run` it");
  }
}

std::map<std::string, double> ReadingsOf(const std::vector<std::string>& given) {
  std::map<std::string, double> readings;
  for (const std::string& text : given) {
    const std::size_t equals = text.find('=');
    const std::string number =
        equals == std::string::npos ? "" : text.substr(equals + 1);
    double value_mm = 0;
    const auto [end, error] =
        std::from_chars(number.data(), number.data() + number.size(), value_mm);
    if (error != std::errc() || end != number.data() + number.size() ||
        !std::isfinite(value_mm)) {
      throw InputError({.file = "--reading"},
                       fmt::format("'{}' is not ID=MILLIMETRES", text),
                       "such as --reading calliper.block.x=76.198");
    }
    readings[text.substr(0, equals)] = value_mm;
  }
  return readings;
}

void RefuseOverwritten(const CalibrateOptions& options) {
  RefuseOverwriting(
      Together({LinkFiles(options.link),
                MachineFiles(options.machine),
                {{"the bench file", options.bench}}}),
      {{"--record", options.record}, {"--transcript", options.transcript}});
}

void RequireAnswers(const CalibrateOptions& options) {
  if (!options.apply || options.yes || CanAsk()) return;
  throw InputError({},
                   "--apply asks before each change, and stdin is no terminal",
                   "add --yes to change the machine's settings without being asked");
}

std::string EstimateText(const Estimate& estimate) {
  if (!estimate.identifiable) return estimate.name + " cannot be told";
  ParameterResult row{
      .name = estimate.name, .unit = estimate.unit, .recovered = estimate.value};
  SetUncertainty(estimate, &row);
  const std::string text = UncertaintyText(row);
  if (!text.empty()) return text;
  return fmt::format("{}: {} {}",
                     estimate.name,
                     Sensible(estimate.value, std::nullopt),
                     estimate.unit);
}

void PrintResult(const std::string& name, const ProcedureResult& result) {
  std::cout << name << "\n";
  for (const Estimate& estimate : result.estimates) {
    std::cout << "  " << EstimateText(estimate) << "\n";
  }
  std::vector<Budgeted> told;
  for (const Estimate& estimate : result.estimates) {
    if (!estimate.identifiable) continue;
    told.push_back({.name = estimate.name, .budget = estimate.budget});
  }
  for (const Correlations& of : AllCorrelations(told, result.correlations)) {
    const std::string text = CorrelationText(of);
    if (!text.empty()) std::cout << "  " << text << "\n";
  }
  for (const Step& step : result.steps) {
    std::cout << fmt::format("  {} {:.7g} -> {:.7g}, {}. {}\n",
                             step.name,
                             step.before,
                             step.after,
                             ToString(step.verdict),
                             step.message);
  }
  for (const Observability& o : result.observability) {
    std::cout << "  " << o.statement << "\n";
  }
  for (const Message& message : result.messages) {
    std::cout << "  " << message.text << "\n";
  }
  // Some procedures have said so already.
  const std::string said = MachineSaid(result.fault).text;
  if (!result.fault.empty() &&
      std::ranges::find(result.messages, said, &Message::text) ==
          result.messages.end()) {
    std::cout << "  " << said << "\n";
  }
}

namespace {

// Without --apply nothing is applied, which is no fault; a call for the operator is.
bool IsRefusedAsAsked(const CalibrateOptions& options, const ProcedureResult& result) {
  const auto alerts = result.figures.find("alerts");
  const bool is_alerted = alerts != result.figures.end() && alerts->second > 0;
  return !options.apply && result.fault.empty() && !is_alerted;
}

}  // namespace

bool StopsTheRest(const CalibrateOptions& options, const ProcedureResult& result) {
  if (InterruptRequested()) return true;
  switch (result.ending) {
    case Ending::kDone:
    case Ending::kUnconverged:
    case Ending::kReadsZero:
    case Ending::kConfounded:
      return false;
    case Ending::kRefused:
      return !IsRefusedAsAsked(options, result);
    case Ending::kNoTrigger:
    case Ending::kCollision:
    case Ending::kAlarm:
    case Ending::kLinkLost:
      break;
  }
  return true;
}

int WorstOf(const CalibrateOptions& options,
            const std::vector<ProcedureResult>& results) {
  const auto any = [&](Ending ending) {
    return std::ranges::find(results, ending, &ProcedureResult::ending) !=
           results.end();
  };
  if (InterruptRequested()) return kInterrupted;
  if (any(Ending::kLinkLost)) return kLost;
  const bool all_done = std::ranges::all_of(results, [&](const ProcedureResult& r) {
    return r.ending == Ending::kDone ||
           (r.ending == Ending::kRefused && IsRefusedAsAsked(options, r));
  });
  return all_done ? kPassed : kCheckFailed;
}

}  // namespace caltwin
