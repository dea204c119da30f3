#include "tools/commands/kinds/calibrate_motors.h"

#include <iostream>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "scenarios/interrupt.h"
#include "scenarios/interruptible_link.h"
#include "scenarios/kinds/motor_stage_scenario.h"
#include "sim/base/units.h"
#include "sim/link/open_link.h"
#include "sim/link/transcript.h"
#include "tools/commands/kinds/simulated_stage.h"
#include "tools/commands/terminal.h"
#include "tools/commands/twin_options.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;

constexpr double kLaserSigma_um = 0.5;  // Where the bench does not say.

std::vector<MotorStep> StepsAsked(const CalibrateOptions& options,
                                  const MotorStageDrawing& drawing) {
  RefuseScenarioSteps(options);
  Faults faults;
  YamlMap map = ReadYamlText(ProceduresText(options), "--procedure", &faults);
  auto steps = ReadMotorSteps(*map.Required("calibrate"), drawing);
  faults.ThrowIfAny();
  for (const MotorStep& step : steps) {
    if (step.name != "power_cut") continue;
    throw InputError({.file = "--procedure"},
                     step.name + " is a step of scenarios only",
                     "write a scenario and `caltwin run` it");
  }
  return steps;
}

void RefuseUnheeded(const CalibrateOptions& options, const TwinOptions& papers) {
  if (!options.record.empty()) {
    throw InputError({.file = "--record"},
                     "motors touch nothing: there are no rows",
                     "--transcript keeps each line");
  }
  if (!papers.artefacts.empty()) {
    throw InputError({.file = options.bench},
                     "a motor stage's bench has no artefacts",
                     "it knows instruments: laser");
  }
  if (!options.readings.empty()) {
    throw InputError({.file = "--reading"},
                     "a carriage is read at every approach, each time anew",
                     "they are asked for at the terminal; a twin has its laser");
  }
  if (IsTwin(options) || options.apply) return;
  throw InputError({.file = "--procedure"},
                   "procedures of motor axes home, move and store",
                   "--apply does that, asking before each; on a twin nothing stays");
}

// The stage at hand: a twin or a wire, with the person who is asked.
struct AtHand {
  std::unique_ptr<TerminalOperator> person{};
  std::unique_ptr<SimulatedStage> twin{};
  std::unique_ptr<Link> wire{};
  std::unique_ptr<TerminalGauge> gauge{};
  MotorBench bench{};
};

AtHand Take(const CalibrateOptions& options,
            const MotorStageDrawing& drawing,
            const TwinOptions& papers) {
  const auto laser = papers.instruments.find("laser");
  const double sigma_unit = MmFromUm(
      laser == papers.instruments.end() ? kLaserSigma_um : laser->second.sigma_um);
  AtHand at_hand{.bench = {.drawing = drawing, .gauge_sigma_unit = sigma_unit}};
  at_hand.person = PersonAtHand(options);
  if (IsTwin(options)) {
    at_hand.twin = std::make_unique<SimulatedStage>(
        drawing, TwinOptionsOf(options.link), sigma_unit);
    at_hand.bench.link = &at_hand.twin->link();
    at_hand.bench.gauge = &at_hand.twin->gauge();
  } else {
    at_hand.wire = OpenLink(options.link);
    at_hand.gauge = std::make_unique<TerminalGauge>(std::map<std::string, double>{});
    at_hand.bench.link = at_hand.wire.get();
    at_hand.bench.gauge = at_hand.gauge.get();
  }
  return at_hand;
}

bool MayPerform(const CalibrateOptions& options,
                const MotorStep& step,
                TerminalOperator* person) {
  if (IsTwin(options) && !options.apply) return true;
  return person
      ->Do({.kind = Act::Kind::kConfirm,
            .text = step.name + ": move the axis and store what is found?"})
      .has_value();
}

}  // namespace

std::optional<fs::path> MotorStageToCalibrate(const CalibrateOptions& options) {
  const bool is_twin = IsTwin(options);
  const std::string name =
      is_twin ? TwinOptionsOf(options.link).machine : options.machine;
  if (name.empty()) return std::nullopt;
  fs::path file = FindMachine(name, "", {.file = is_twin ? name : "--machine"});
  return IsMotorStage(file) ? std::optional(std::move(file)) : std::nullopt;
}

int CalibrateMotorsAtHand(const CalibrateOptions& options, const fs::path& machine) {
  const MotorStageDrawing drawing = ReadMotorStage(machine);
  const std::vector<MotorStep> steps = StepsAsked(options, drawing);
  RefuseOverwritten(options);
  TwinOptions papers;
  if (!options.bench.empty()) ReadBenchFile(options.bench, &papers);
  RefuseUnheeded(options, papers);
  AtHand at_hand = Take(options, drawing, papers);
  InterruptibleLink interruptible(at_hand.bench.link);
  std::unique_ptr<RecordingLink> recorder;
  if (!options.transcript.empty()) {
    recorder = std::make_unique<RecordingLink>(&interruptible, options.transcript);
  }
  at_hand.bench.link = recorder ? static_cast<Link*>(recorder.get()) : &interruptible;
  MotorAxes axes(at_hand.bench);
  std::vector<ProcedureResult> results;
  for (const MotorStep& step : steps) {
    if (!MayPerform(options, step, at_hand.person.get())) {
      std::cout << step.name << ": not done\n";
      results.push_back({.ending = Ending::kRefused});
      break;
    }
    results.push_back(RunMotorProcedure(step.name, step.options, &axes).result);
    PrintResult(step.name, results.back());
    const Ending ending = results.back().ending;
    const bool goes_on = ending == Ending::kDone || ending == Ending::kConfounded;
    if (!goes_on || InterruptRequested()) break;
  }
  if (recorder) recorder->Save();
  if (IsTwin(options)) std::cout << "The twin, and what it stored, is gone.\n";
  return WorstOf(options, results);
}

}  // namespace caltwin
