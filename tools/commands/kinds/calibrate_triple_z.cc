#include "tools/commands/kinds/calibrate_triple_z.h"

#include <iostream>
#include <memory>

#include <fmt/format.h>

#include "calibration/kinds/triple_z/procedures.h"
#include "scenarios/interruptible_link.h"
#include "scenarios/kinds/triple_z_scenario.h"
#include "scenarios/kinds/triple_z_wire.h"
#include "sim/link/open_link.h"
#include "sim/link/transcript.h"
#include "tools/commands/kinds/simulated_printer.h"
#include "tools/commands/terminal.h"
#include "tools/commands/twin_options.h"

namespace caltwin {
namespace {

// The printer at hand: a twin or a wire, with the person who is asked.
struct PrinterAtHand {
  std::unique_ptr<SimulatedPrinter> twin{};
  std::unique_ptr<Link> wire{};
  std::unique_ptr<TerminalOperator> person{};
  Link* link = nullptr;
};

std::vector<TripleZStep> PrinterStepsOf(const CalibrateOptions& options) {
  if (!options.axis.empty()) {
    throw InputError({.file = "--axis"}, "a triple-Z printer is levelled as a whole");
  }
  RefuseScenarioSteps(options);
  Faults faults;
  YamlMap map = ReadYamlText(ProceduresText(options), "--procedure", &faults);
  auto steps = ReadTripleZSteps(*map.Required("calibrate"));
  faults.ThrowIfAny();
  return steps;
}

void RefuseWhatIsNotHeeded(const CalibrateOptions& options, const TwinOptions& papers) {
  if (!options.record.empty()) {
    throw InputError({.file = "--record"},
                     "levelling writes no rows",
                     "`caltwin simulate` measures a printer; --transcript keeps each "
                     "line");
  }
  if (!options.readings.empty()) {
    throw InputError({.file = "--reading"}, "levelling asks for no gauge");
  }
  if (!papers.artefacts.empty()) {
    throw InputError({.file = options.bench},
                     "a printer's bench has no artefacts",
                     "it knows instruments: probe");
  }
}

PrinterAtHand TakePrinter(const CalibrateOptions& options, const TwinOptions& papers) {
  PrinterAtHand at_hand;
  at_hand.person = PersonAtHand(options);
  if (IsTwin(options)) {
    TwinOptions named = TwinOptionsOf(options.link);
    named.instruments = papers.instruments;
    at_hand.twin = std::make_unique<SimulatedPrinter>(named);
    at_hand.link = &at_hand.twin->link();
  } else {
    at_hand.wire = OpenLink(options.link);
    at_hand.link = at_hand.wire.get();
  }
  return at_hand;
}

// The bed touched, and what levelling it would raise.
TripleZResult OnlyTouch(TripleZPrinter* printer, const TripleZOptions& options) {
  TripleZResult done = RunPlaneTilt(printer, options);
  if (!done.plane || !done.plane->is_told()) return done;
  const Vec3<double> raise_mm = ScrewOffsets_mm(
      *done.plane, printer->bench().drawn_mm, options.reference_mm, options.rule);
  done.result.messages.push_back(
      fmt::format("--apply would raise the screws by {:+.4f} {:+.4f} {:+.4f} mm",
                  raise_mm[0],
                  raise_mm[1],
                  raise_mm[2]));
  return done;
}

// Whether the step is to be done as it is: the person is asked before screws stay
// moved.
bool MayApply(const TripleZStep& step, TerminalOperator* person) {
  const std::string what =
      step.name == "pivots_and_wiring"
          ? "pivots_and_wiring: write where the screws are found to stand (M671)?"
          : step.name + ": move the screws?";
  return person->Do({.kind = Act::Kind::kConfirm, .text = what}).has_value();
}

TripleZResult PerformStep(const TripleZStep& step,
                          TerminalOperator* person,
                          TripleZPrinter* printer) {
  TripleZOptions o = step.options;
  if (step.name == "plane_tilt") return RunPlaneTilt(printer, o);
  const bool may_apply = MayApply(step, person);
  if (step.name == "pivots_and_wiring") {
    if (!may_apply && o.from_rounds) return OnlyTouch(printer, o);
    o.is_as_published = o.is_as_published || !may_apply;  // Says it, writes nothing.
    return RunPivotsAndWiring(printer, o);
  }
  if (!may_apply) return OnlyTouch(printer, o);
  return step.name == "rrf_levelling" ? RunRrfLevelling(printer, o)
                                      : RunBedTilt(printer, o);
}

void RequireProcedures(const std::vector<TripleZStep>& steps) {
  for (const TripleZStep& step : steps) {
    if (step.name != "move_triple_z") continue;
    throw InputError({.file = "--procedure"},
                     step.name + " is a step of scenarios only",
                     "write a scenario and `caltwin run` it");
  }
}

}  // namespace

int CalibrateTripleZAtHand(const CalibrateOptions& options, const MachineFile& file) {
  const std::vector<TripleZStep> steps = PrinterStepsOf(options);
  RequireProcedures(steps);
  RefuseOverwritten(options);
  TwinOptions papers;
  if (!options.bench.empty()) ReadBenchFile(options.bench, &papers);
  RefuseWhatIsNotHeeded(options, papers);
  const PrinterAtHand at_hand = TakePrinter(options, papers);
  InterruptibleLink interruptible(at_hand.link);
  std::unique_ptr<RecordingLink> recorder;
  if (!options.transcript.empty()) {
    recorder = std::make_unique<RecordingLink>(&interruptible, options.transcript);
  }
  TripleZPrinter printer(
      BenchOf(file.machine,
              recorder ? static_cast<Link*>(recorder.get()) : &interruptible,
              ProbeSigma_mm(papers.instruments)));
  std::vector<ProcedureResult> results;
  for (const TripleZStep& step : steps) {
    results.push_back(PerformStep(step, at_hand.person.get(), &printer).result);
    PrintResult(step.name, results.back());
    if (StopsTheRest(results.back())) break;
  }
  if (recorder) recorder->Save();
  if (!options.apply) std::cout << "Nothing was applied: --apply does that.\n";
  return WorstOf(options, results);
}

}  // namespace caltwin
