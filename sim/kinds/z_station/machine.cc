#include "sim/kinds/z_station/machine.h"

#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "sim/base/require.h"
#include "sim/effects/predict.h"
#include "sim/machine/kinds/z_station/drawing.h"

namespace caltwin {
namespace {

// Where the parts stand, the head's over the height of its drawn tip.
ZStationBuild BuildOf(const ZStationDrawing& drawing, const Errors<double>& errors) {
  const double lifted_mm = errors.motion_mm[2];
  return {
      .tip_mm = lifted_mm - errors.nozzle_mm - errors.ooze_mm,
      .body_mm = lifted_mm - drawing.body_mm,
      .trigger_mm = drawing.trigger_mm + errors.trigger_mm - errors.more_pretravel_mm,
      .switch_mm = drawing.switch_mm,
      .surface_mm = errors.artefact_mm};
}

}  // namespace

ZStationBuild BuildOf(const Machine& machine, const std::vector<Injected>& effects) {
  const ZStationDrawing& drawing = ZStationOf(machine);
  At over;
  over.kind = RowKind::kTouch;
  over.station = ZReading::kProbeOnBed;
  over.on_table = true;
  over.q_mm.head<2>() = drawing.bed_at_mm;
  return BuildOf(drawing, ErrorsAt<double>(machine, over, effects));
}

ZStationMachine::ZStationMachine(const Machine& machine,
                                 const std::vector<Injected>& effects,
                                 bool is_physics)
    : machine_(machine), effects_(effects) {
  Require(machine.Own<ZStationDrawing>() != nullptr,
          "the machine is a printer's station");
  if (!is_physics) return;
  world_ =
      std::make_unique<ZStationWorld>(ShareFolder() / "models/z_station/model.xml");
}

double ZStationMachine::Trigger_mm(const Row& row, const At& at, ZReading reading) {
  At here = at;
  here.kind = RowKind::kTouch;
  here.station = reading;
  here.on_table = reading == ZReading::kProbeOnBed;
  const auto errors = ErrorsAt<double>(machine_, here, effects_);
  const double expected_mm =
      ZStationOf(machine_).Nominal_mm(reading) + Value_mm(here, errors);
  if (!world_) return expected_mm;
  const auto found_mm =
      world_->Lower(reading == ZReading::kNozzleOnSwitch ? ZContact::kNozzleOnSwitch
                    : reading == ZReading::kBodyOnSwitch ? ZContact::kBodyOnSwitch
                                                         : ZContact::kKnobOnSurface,
                    BuildOf(ZStationOf(machine_), errors),
                    expected_mm);
  if (found_mm) return *found_mm;
  throw InputError(
      row.place,
      fmt::format(
          "row {}: {} does not trigger in the simulation", row.row, FeatureOf(reading)),
      "are the errors in um, and the station as the machine file has it?");
}

// As CALIBRATE_Z has it, with the switch_offset that is drawn, and the clean nozzle
// then commanded to 0.
double ZStationMachine::Gap_mm(const Row& row, const At& at) {
  const double nozzle_mm = Trigger_mm(row, at, ZReading::kNozzleOnSwitch);
  const double switch_mm = Trigger_mm(row, at, ZReading::kBodyOnSwitch);
  const double probe_mm = Trigger_mm(row, at, ZReading::kProbeOnBed);
  const double nought_mm =
      probe_mm - (switch_mm - nozzle_mm + ZStationOf(machine_).trigger_mm);
  At over = at;
  over.station = ZReading::kProbeOnBed;
  over.on_table = true;
  const auto errors = ErrorsAt<double>(machine_, over, effects_);
  return nought_mm + errors.motion_mm[2] - errors.nozzle_mm - errors.artefact_mm;
}

double ZStationMachine::Reading_mm(const Row& row, const At& at) {
  if (at.station == ZReading::kGapUnderNozzle) return Gap_mm(row, at);
  auto homed = homed_at_mm_.find(row.home);
  if (homed == homed_at_mm_.end()) {
    const double at_mm =
        Trigger_mm(row, at, ZReading::kNozzleOnSwitch) - ZStationOf(machine_).switch_mm;
    homed = homed_at_mm_.emplace(row.home, at_mm).first;
  }
  return Trigger_mm(row, at, *at.station) -
         ZStationOf(machine_).Nominal_mm(*at.station) - homed->second;
}

}  // namespace caltwin
