#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "calibration/loop/bench.h"
#include "scenarios/interruptible_link.h"
#include "scenarios/kinds/kinds.h"
#include "scenarios/machine_file.h"
#include "scenarios/scenario.h"
#include "sim/link/open_link.h"
#include "sim/link/transcript.h"
#include "sim/measure/rows.h"
#include "tools/commands/calibrate.h"
#include "tools/commands/command.h"
#include "tools/commands/kinds/calibrate_as_kind.h"
#include "tools/commands/progress.h"
#include "tools/commands/terminal.h"
#include "tools/commands/twin_options.h"

namespace caltwin {
namespace {

using Options = CalibrateOptions;

// The machine at hand: a twin or a wire, with hands and gauges that suit it.
struct AtHand {
  std::unique_ptr<Twin> twin{};
  std::unique_ptr<Link> wire{};
  Link* link = nullptr;  ///< The twin's or the wire.
  std::unique_ptr<Operator> person{};
  std::unique_ptr<Gauge> gauge{};
  Bench bench{};
};

std::vector<CalibrationStep> StepsOf(const Options& options) {
  Faults faults;
  YamlMap map = ReadYamlText(ProceduresText(options), "--procedure", &faults);
  const auto file = MachineToCalibrate(options);
  const auto kind = UsualKind(file ? file->machine.kind : CartesianKind());
  const auto steps = ReadCalibrationSteps(*map.Required("calibrate"), *kind);
  faults.ThrowIfAny();
  for (const CalibrationStep& step : steps) {
    if (step.external) {
      throw InputError({.file = "--procedure"},
                       "external programs are run by scenarios only",
                       "write a scenario and `caltwin run` it");
    }
  }
  return steps;
}

void TakeTwin(const Options& options, TwinOptions twin_options, AtHand* at_hand) {
  const TwinOptions named = TwinOptionsOf(options.link);
  twin_options.machine = named.machine;
  twin_options.truth = named.truth;
  twin_options.fidelity = named.fidelity;
  twin_options.seed = named.seed;
  const TwinConfig config = MakeTwinConfig(twin_options);
  at_hand->twin = std::make_unique<Twin>(config);
  at_hand->link = &at_hand->twin->link();
  // A twin's hands are its own; only applying is asked of the person, and that only
  // where one is there.
  const bool yes = options.yes || !CanAsk();
  at_hand->person = std::make_unique<ConfirmingOperator>(
      TerminalOperator::Options{.apply = options.apply, .yes = yes},
      &at_hand->twin->person());
  at_hand->bench.gauge = &at_hand->twin->gauge();
  at_hand->bench.machine = config.machine;
  at_hand->bench.artefacts = config.artefacts;
  at_hand->bench.instruments = config.instruments;
}

void TakeWire(const Options& options, const TwinOptions& papers, AtHand* at_hand) {
  const std::string machine =
      options.machine.empty() ? TwinOptions{}.machine : options.machine;
  RequireAnswers(options);
  at_hand->bench.machine =
      ReadMachineFile(FindMachine(machine, "", {.file = "--machine"})).machine;
  at_hand->bench.artefacts = papers.artefacts.empty()
                                 ? UsualArtefacts(at_hand->bench.machine)
                                 : papers.artefacts;
  at_hand->bench.instruments = papers.instruments;
  at_hand->wire = OpenLink(options.link);
  at_hand->link = at_hand->wire.get();
  at_hand->person = std::make_unique<TerminalOperator>(
      TerminalOperator::Options{.apply = options.apply, .yes = options.yes});
  at_hand->gauge = std::make_unique<TerminalGauge>(ReadingsOf(options.readings));
  at_hand->bench.gauge = at_hand->gauge.get();
}

AtHand Take(const Options& options) {
  TwinOptions papers;
  if (!options.bench.empty()) ReadBenchFile(options.bench, &papers);
  AtHand at_hand;
  if (options.link.starts_with("twin:")) {
    TakeTwin(options, papers, &at_hand);
  } else {
    TakeWire(options, papers, &at_hand);
  }
  at_hand.bench.person = at_hand.person.get();
  return at_hand;
}

std::vector<ProcedureResult> Perform(const std::vector<CalibrationStep>& steps,
                                     Bench* bench) {
  ProgressLine progress;
  bench->say = [&](const std::string& text) {
    progress.Show(text);
  };
  std::vector<ProcedureResult> results;
  for (const CalibrationStep& step : steps) {
    results.push_back(step.procedure(bench));
    progress.Clear();
    PrintResult(step.name, results.back());
    if (StopsTheRest(results.back())) break;
  }
  bench->say = [](const std::string&) {
  };
  return results;
}

int Calibrate(const Options& options) {
  if (const auto code = CalibrateAsKind(options)) return *code;
  const std::vector<CalibrationStep> steps = StepsOf(options);
  RefuseOverwritten(options);
  AtHand at_hand = Take(options);
  InterruptibleLink interruptible(at_hand.link);
  std::unique_ptr<RecordingLink> recorder;
  if (!options.transcript.empty()) {
    recorder = std::make_unique<RecordingLink>(&interruptible, options.transcript);
  }
  RowTable rows;
  at_hand.bench.link = recorder ? static_cast<Link*>(recorder.get()) : &interruptible;
  at_hand.bench.record = &rows;
  const std::vector<ProcedureResult> results = Perform(steps, &at_hand.bench);
  if (recorder) recorder->Save();
  if (!options.record.empty()) WriteRows(options.record, rows);
  if (!options.apply) std::cout << "Nothing was applied: --apply does that.\n";
  return WorstOf(options, results);
}

}  // namespace

Action DeclareCalibrate(CLI::App* app) {
  auto options = std::make_shared<Options>();
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
