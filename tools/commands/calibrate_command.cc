#include <algorithm>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "calibration/procedures/catalog.h"
#include "scenarios/interruptible_link.h"
#include "scenarios/kinds/kinds.h"
#include "sim/base/input_error.h"
#include "sim/link/transcript.h"
#include "sim/measure/rows.h"
#include "tools/commands/calibrate.h"
#include "tools/commands/command.h"
#include "tools/commands/kinds/desks.h"
#include "tools/commands/progress.h"

namespace caltwin {
namespace {

// What a twin's link says, or a twin does by itself.
void RefuseBesideATwin(const CalibrateOptions& options) {
  if (!IsTwin(options)) return;
  if (!options.machine.empty()) {
    throw InputError({.file = "--machine"},
                     "a twin's link names its machine",
                     "leave the option away");
  }
  if (!options.readings.empty()) {
    throw InputError({.file = "--reading"},
                     "a twin reads its own gauges",
                     "readings in advance are for a machine on a wire");
  }
}

std::vector<CalibrationStep> StepsOf(const CalibrateOptions& options,
                                     const KindScenario& kind,
                                     const Machine& machine) {
  const Procedures known = kind.KnownProcedures();
  Faults faults;
  YamlMap map = ReadYamlText(ProceduresText(options, known), "--procedure", &faults);
  auto steps = ReadCalibrationSteps(*map.Required("calibrate"), kind, machine);
  faults.ThrowIfAny();
  RefuseScenarioSteps(steps, kind);
  return steps;
}

std::vector<ProcedureResult> Perform(const CalibrateOptions& options,
                                     const std::vector<CalibrationStep>& steps,
                                     Desk* desk) {
  ProgressLine progress;
  desk->bench()->say = [&](const std::string& text) {
    progress.Show(text);
  };
  std::vector<ProcedureResult> results;
  if (auto begun = desk->Begin()) {
    results.push_back(*std::move(begun));
    if (StopsTheRest(options, results.back())) PrintResult("G28", results.back());
  }
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (!results.empty() && StopsTheRest(options, results.back())) {
      std::cout << fmt::format(
          "{} of {} steps were not reached\n", steps.size() - i, steps.size());
      break;
    }
    desk->BeforeStep(steps[i]);
    results.push_back(steps[i].procedure(desk->bench()));
    progress.Clear();
    PrintResult(steps[i].name, results.back());
  }
  desk->End();
  desk->bench()->say = [](const std::string&) {
  };
  return results;
}

int Calibrate(const CalibrateOptions& options) {
  const auto file = MachineToCalibrate(options);
  const Machine machine = file ? file->machine : Machine{};
  const auto kind = KindFor(machine, IsOfStation(options.procedures.front()));
  const Procedures known = kind->KnownProcedures();
  const DeskKind& desks = DeskKindOf(known.empty() ? "" : known.front()->kind);
  TwinOptions papers;
  if (!options.bench.empty()) ReadBenchFile(options.bench, &papers);
  RefuseBesideATwin(options);
  desks.refuse(options, papers, file);
  const std::vector<CalibrationStep> steps = StepsOf(options, *kind, machine);
  RefuseOverwritten(options);
  const std::unique_ptr<Desk> desk = desks.make(options, papers, file);
  InterruptibleLink interruptible(desk->wire());
  std::unique_ptr<RecordingLink> recorder;
  if (!options.transcript.empty()) {
    recorder = std::make_unique<RecordingLink>(&interruptible, options.transcript);
  }
  desk->Connect(recorder ? static_cast<Link*>(recorder.get()) : &interruptible);
  const std::vector<ProcedureResult> results = Perform(options, steps, desk.get());
  if (recorder) recorder->Save();
  if (!options.record.empty()) WriteRows(options.record, *desk->bench()->record);
  if (std::ranges::find(steps, "gcode", &CalibrationStep::name) != steps.end()) {
    std::cout << "Lines of `gcode` were sent as they are.\n";
  } else if (const std::string last = desk->Farewell(); !last.empty()) {
    std::cout << last << "\n";
  }
  return WorstOf(options, results);
}

}  // namespace

Action DeclareCalibrate(CLI::App* app) {
  auto options = std::make_shared<CalibrateOptions>();
  app->add_option("--link",
                  options->link,
                  "twin:M.yaml?truth=T.yaml, serial:/dev/ttyACM0?baud=115200, "
                  "tcp:host:port or transcript:FILE")
      ->required();
  app->add_option("--procedure",
                  options->procedures,
                  "what to run, in order: a name, or 'name: {option: value}' as in a "
                  "scenario")
      ->required();
  app->add_option("--axis", options->axis, "for each procedure given by name alone")
      ->check(CLI::IsMember({"x", "y", "z", "a", "u", "v"}));
  app->add_option("--variant", options->variant, "as_published or corrected")
      ->check(CLI::IsMember({"as_published", "corrected"}));
  app->add_option(
      "--machine", options->machine, "its drawing, where the link is no twin");
  app->add_option("--bench",
                  options->bench,
                  "a file with `artefacts` and `instruments`; without it the 1-2-3 "
                  "block lies in the middle of the table, 76.2 mm along x");
  app->add_option(
      "--reading", options->readings, "a gauge's reading in advance, ID=MILLIMETRES");
  app->add_option(
      "--record", options->record, "write every reading as rows (FILE.csv)");
  app->add_option(
      "--transcript", options->transcript, "write every line and its answer");
  app->add_flag(
      "--apply", options->apply, "change the machine's settings, after asking");
  app->add_flag("--yes", options->yes, "do not ask");
  app->footer(
      "On a twin the block is turned by simulated hands; on a real machine you are "
      "asked. Without --apply it only measures.");
  return [options] {
    return Calibrate(*options);
  };
}

}  // namespace caltwin
