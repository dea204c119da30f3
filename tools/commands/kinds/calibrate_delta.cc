#include "tools/commands/kinds/calibrate_delta.h"

#include <iostream>
#include <memory>

#include <fmt/format.h>

#include "calibration/kinds/delta/calibrate.h"
#include "calibration/kinds/delta/klipper_descent.h"
#include "calibration/kinds/delta/procedures.h"
#include "scenarios/interrupt.h"
#include "scenarios/interruptible_link.h"
#include "scenarios/kinds/delta_g33.h"
#include "scenarios/kinds/delta_scenario.h"
#include "sim/base/units.h"
#include "sim/kinds/delta/twin.h"
#include "sim/link/open_link.h"
#include "sim/link/transcript.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/measure/rows.h"
#include "tools/commands/terminal.h"
#include "tools/commands/twin_options.h"

namespace caltwin {
namespace {

// The machine at hand: a twin or a wire, with the person and calliper that suit it.
struct AtHand {
  std::unique_ptr<DeltaTwin> twin{};
  std::unique_ptr<Link> wire{};
  std::unique_ptr<TerminalOperator> person{};
  std::unique_ptr<TerminalGauge> gauge{};
  DeltaBench bench{};
};

std::vector<DeltaStep> StepsOf(const CalibrateOptions& options) {
  RefuseScenarioSteps(options);
  Faults faults;
  YamlMap map = ReadYamlText(ProceduresText(options), "--procedure", &faults);
  auto steps = ReadDeltaSteps(*map.Required("calibrate"));
  faults.ThrowIfAny();
  return steps;
}

// What the person at the terminal reads; print distances are asked in their order.
DeltaCalliper AskedCalliper(TerminalGauge* gauge, double sigma_mm) {
  const auto ask = [gauge](const std::string& id) -> std::optional<double> {
    const auto read_mm = gauge->Read_mm(id);
    if (!read_mm) std::cerr << read_mm.error().reply << "\n";
    return read_mm ? std::optional(*read_mm) : std::nullopt;
  };
  const auto next = std::make_shared<std::size_t>(0);
  return {.rod_mm = [ask](int rod) { return ask("calliper.rod." + RodName(rod)); },
          .between_mm =
              [ask, next](const Vec3<double>&, const Vec3<double>&) {
                const std::size_t at = (*next)++ % KlipperPrint().size();
                return ask(fmt::format("calliper.print.{}", at + 1));
              },
          .sigma_mm = sigma_mm};
}

AtHand Take(const CalibrateOptions& options, const MachineFile& file) {
  TwinOptions papers;
  if (!options.bench.empty()) ReadBenchFile(options.bench, &papers);
  if (!papers.artefacts.empty()) {
    throw InputError({.file = options.bench},
                     "a delta's bench has no artefacts",
                     "it knows instruments: probe and calliper");
  }
  AtHand at_hand;
  at_hand.person = PersonAtHand(options);
  if (IsTwin(options)) {
    TwinOptions named = TwinOptionsOf(options.link);
    named.instruments = papers.instruments;
    at_hand.twin = std::make_unique<DeltaTwin>(MakeDeltaTwinConfig(file, named));
    at_hand.bench.link = &at_hand.twin->link();
    at_hand.bench.calliper = CalliperOf(at_hand.twin.get());
  } else {
    at_hand.wire = OpenLink(options.link);
    at_hand.bench.link = at_hand.wire.get();
    at_hand.gauge = std::make_unique<TerminalGauge>(ReadingsOf(options.readings));
    at_hand.bench.calliper =
        AskedCalliper(at_hand.gauge.get(), CalliperSigma_mm(papers.instruments));
  }
  at_hand.bench.person = at_hand.person.get();
  at_hand.bench.machine = file.machine;
  at_hand.bench.probe_sigma_mm = ProbeSigma_mm(papers.instruments);
  return at_hand;
}

}  // namespace

int CalibrateDeltaAtHand(const CalibrateOptions& options, const MachineFile& file) {
  const std::vector<DeltaStep> steps = StepsOf(options);
  RefuseOverwritten(options);
  AtHand at_hand = Take(options, file);
  InterruptibleLink interruptible(at_hand.bench.link);
  std::unique_ptr<RecordingLink> recorder;
  if (!options.transcript.empty()) {
    recorder = std::make_unique<RecordingLink>(&interruptible, options.transcript);
  }
  at_hand.bench.link = recorder ? static_cast<Link*>(recorder.get()) : &interruptible;
  DeltaRecord record;
  at_hand.bench.record = &record;
  std::vector<ProcedureResult> results;
  for (const DeltaStep& step : steps) {
    if (at_hand.twin) {
      at_hand.twin->SetG33(
          MarlinG33(VariantOf(step), DeltaOf(file.machine).print_radius_mm));
    }
    results.push_back(CalibrateDelta(step, at_hand.bench));
    PrintResult(step.name, results.back());
    if (StopsTheRest(results.back())) break;
  }
  if (recorder) recorder->Save();
  if (!options.record.empty()) WriteRows(options.record, record.rows);
  if (!options.apply) std::cout << "Nothing was applied: --apply does that.\n";
  return WorstOf(options, results);
}

}  // namespace caltwin
