#include "scenarios/kinds/delta_shipped.h"

#include <memory>
#include <optional>

#include "scenarios/klipper/host.h"
#include "sim/controllers/klipper/printer_cfg.h"
#include "sim/kinds/delta/klipper.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/machine.h"
#include "sim/measure/import/klipper_geometry.h"

namespace caltwin {

DeltaModel<double> DeltaBelievedBy(const std::string& printer_cfg) {
  Faults faults;
  const PrinterCfg cfg(printer_cfg, "printer.cfg");
  const auto geometry = ReadKlipperGeometry(cfg, std::nullopt, &faults);
  faults.ThrowIfAny();
  return geometry->model;
}

DeltaOutcome CalibrateByKalico(const BuiltDelta& built,
                               double radius_mm,
                               std::uint64_t seed) {
  const Machine machine =
      ReadMachine(ShareFolder() / "models/delta_printer/machine.yaml");
  PlantBoard board(
      WiringOfDelta(machine),
      std::make_unique<SteppedDelta>(machine, built, /*is_physics=*/false, seed));
  KlipperHost host(
      &board,
      {.config = PrinterCfgOfDelta(machine, "-"),
       .add = "[delta_calibrate]\nradius: " + klipper::CfgNumber(radius_mm) + "\n"});
  DeltaOutcome outcome{.settings = DeltaOf(machine).settings};
  for (const char* const line : {"G28", "DELTA_CALIBRATE", "SAVE_CONFIG"}) {
    const HostAnswer answer = host.Say(line);
    for (const std::string& printed : answer.lines) {
      outcome.touches += printed.find("probe at ") != std::string::npos ? 1 : 0;
    }
    const auto& why = answer.refusal ? answer.refusal : answer.shut_down;
    if (!why) continue;
    outcome.messages = {*why};
    return outcome;
  }
  outcome.messages = {host.Config()};
  outcome.settings = DeltaBelievedBy(outcome.messages.front());
  outcome.is_done = true;
  return outcome;
}

}  // namespace caltwin
