#include "sim/measure/kinds/delta_rows.h"

#include <algorithm>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {

DeltaRows::DeltaRows(const Machine& machine, double sigma_mm, DeltaRecord* record)
    : machine_(machine), record_(record) {
  DataHeader& header = record->header;
  header.machine = machine.name;
  header.instruments["probe"] = {.kind = "probe", .sigma_um = UmFromMm(sigma_mm)};
  for (int i = 0; i < kNumTowers; ++i) {
    const AxisDrawing& drawing = machine.axis(static_cast<Axis>(i));
    Transmission& transmission = header.transmission[TowerName(i)];
    (drawing.is_belt ? transmission.pulley_mm_per_rev : transmission.lead_mm) =
        drawing.lead_mm;
    transmission.full_steps_per_mm = drawing.full_steps_per_rev / drawing.lead_mm;
  }
}

void DeltaRows::Begin(const std::string& campaign) {
  campaign_ = campaign;
  record_->header.campaigns[campaign].instrument = "probe";
}

std::string DeltaRows::IdOf(const DeltaModel<double>& settings) {
  const auto same = [&](const DeltaModel<double>& one) {
    return one.endstop_mm == settings.endstop_mm &&
           one.radius_mm == settings.radius_mm && one.angle_rad == settings.angle_rad &&
           one.arm_mm == settings.arm_mm;
  };
  const auto found = std::ranges::find_if(seen_, same);
  const std::string id = fmt::format("s{}", found - seen_.begin() + 1);
  if (found != seen_.end()) return id;
  seen_.push_back(settings);
  const auto steps_per_mm = TowerStepsPerMm(machine_);
  for (int i = 0; i < kNumTowers; ++i) {
    record_->header.settings[id].steps_per_mm[TowerName(i)] =
        steps_per_mm[static_cast<std::size_t>(i)];
  }
  return id;
}

void DeltaRows::Add(const DeltaModel<double>& settings,
                    const Vec3<double>& counted_mm) {
  const Vec3<double> nozzle_mm = DeltaNozzle_mm(settings, counted_mm);
  // Where the nozzle would be with the tip, as the firmware has it, on the nominal bed.
  const Vec3<double> nominal_mm(nozzle_mm[0], nozzle_mm[1], -offset_mm_[2]);
  const Vec3<double> motors_mm = DeltaMotors_mm(settings, nominal_mm);
  Row row{.row = static_cast<std::int64_t>(record_->rows.rows.size()) + 1,
          .campaign = campaign_,
          .kind = RowKind::kTouch,
          .setup = "bed",
          .settings = IdOf(settings)};
  row.cmd_mm = {nozzle_mm[0] + offset_mm_[0], nozzle_mm[1] + offset_mm_[1], 0};
  row.motor_mm = {motors_mm[0], motors_mm[1], motors_mm[2]};
  row.dir[2] = -1;
  row.n = {0, 0, 1};
  row.feature = "bed.top";
  if (!offset_mm_.isZero(0)) {
    row.probe_off_mm = {offset_mm_[0], offset_mm_[1], offset_mm_[2]};
  }
  row.value_mm = nozzle_mm[2] - nominal_mm[2];
  row.motor_dir = {1, 1, 1};  // The nozzle came straight down, so did all carriages.
  record_->rows.rows.push_back(std::move(row));
}

}  // namespace caltwin
