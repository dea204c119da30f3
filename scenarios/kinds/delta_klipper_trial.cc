#include "scenarios/kinds/delta_klipper_trial.h"

#include <utility>

#include "sim/kinds/delta/klipper.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/measure/import/klipper_geometry.h"

namespace caltwin {
namespace {

// What a host with that printer.cfg believes of the machine.
DeltaModel<double> BelievedBy(const std::string& config) {
  Faults faults;
  const PrinterCfg cfg(config, "printer.cfg");
  const auto geometry = ReadKlipperGeometry(cfg, std::nullopt, &faults);
  faults.ThrowIfAny();
  return geometry->model;
}

}  // namespace

DeltaKlipperTrial::DeltaKlipperTrial(const Machine& machine,
                                     const BuiltDelta& built,
                                     std::unique_ptr<Board> board,
                                     KlipperHostOptions options)
    : KlipperTrial(machine, std::move(board), std::move(options)),
      machine_(machine),
      built_(built),
      truth_{.machine = machine_, .built = built_} {
  truth_.before = BelievedBy(config_before());
}

void DeltaKlipperTrial::Finish(RunResult* result) {
  KlipperTrial::Finish(result);
  truth_.after = BelievedBy(host()->Config());
  truth_.after_first = truth_.after;
  result->position_error_before_p95_mm = DeltaPositionP95_mm(truth_, truth_.before, {});
  result->position_error_after_p95_mm = DeltaPositionP95_mm(truth_, truth_.after, {});
}

void DeltaKlipperTrial::AddParameters(const Expectation& /*expect*/,
                                      const std::vector<ProcedureResult>& /*results*/,
                                      RunResult* result) {
  AddDeltaTable(truth_, result);
}

TrueEnd DeltaKlipperTrial::End(const std::vector<ProcedureResult>& /*results*/,
                               RunResult* result) {
  return EndOfDelta(truth_, result);
}

double DeltaKlipperTrial::Figure(const std::string& name, const RunResult& result) {
  return FigureOfDelta(truth_, name, result);
}

std::unique_ptr<KindTrial> BeginDeltaUnderKlipper(const DeltaScenario& delta,
                                                  const Scenario& scenario,
                                                  const Chance& chance) {
  Machine machine = scenario.machine.machine;
  DeltaOf(machine).settings = delta.settings;
  const BuiltDelta built = DrawDelta(delta, machine, chance.seed, chance.sample);
  auto board = std::make_unique<PlantBoard>(
      WiringOfDelta(machine),
      std::make_unique<SteppedDelta>(
          machine, built, chance.fidelity == Fidelity::kPhysics, chance.seed));
  KlipperHostOptions options = *scenario.klipper;
  if (options.config.empty()) options.config = PrinterCfgOfDelta(machine, "-");
  return std::make_unique<DeltaKlipperTrial>(
      machine, built, std::move(board), std::move(options));
}

}  // namespace caltwin
