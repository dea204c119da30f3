#include "sim/kinds/readings.h"

#include <cmath>

#include "sim/base/units.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/machine_kind.h"
#include "sim/measure/in_force.h"

namespace caltwin {

Readings::Readings(const PerformConfig& config, const std::vector<Row>& rows)
    : config_(config),
      surroundings_(rows),
      noise_(config.seed, 0, "perform.instrument"),
      scatter_(config.seed, 0, "perform.scatter") {
  for (const Row& row : rows) {
    if (settings_.contains(row.settings)) continue;
    settings_.emplace(row.settings,
                      InForce(config.header, config.machine, row.settings));
  }
}

const Settings& Readings::SettingsFor(const Row& row) const {
  return settings_.at(row.settings);
}

At Readings::AtFor(const Row& row) const {
  At at = AtOf(row, config_.machine, SettingsFor(row));
  surroundings_.Complete(row, &at);
  const auto artefact = config_.header.artefacts.find(std::string(at.artefact));
  at.inside = artefact != config_.header.artefacts.end() &&
              (artefact->second.type == "ring" || artefact->second.type == "pocket");
  return row.kind == RowKind::kTouch ? WithValue(at, row, 0) : at;
}

At Readings::WithValue(At at, const Row& row, double value_mm) {
  for (int i = 0; i < 3; ++i) {
    const double nominal_mm = row.cmd_mm[static_cast<std::size_t>(i)];
    if (!Known(nominal_mm)) continue;
    at.q_mm[i] =
        nominal_mm + (value_mm + at.tip_radius_cfg_mm) * at.n[i] - at.probe_off_mm[i];
  }
  return at;
}

const Instrument& Readings::InstrumentFor(const Row& row) const {
  static const Instrument kIdeal;
  const auto campaign = config_.header.campaigns.find(row.campaign);
  const std::string id = campaign == config_.header.campaigns.end()
                             ? (row.kind == RowKind::kTouch ? "probe" : "laser")
                             : campaign->second.instrument;
  const auto instrument = config_.header.instruments.find(id);
  return instrument == config_.header.instruments.end() ? kIdeal : instrument->second;
}

Vec3<double> Readings::Reachable_mm(const Vec3<double>& q_mm,
                                    const Settings& settings) const {
  if (const auto* delta = config_.machine.Own<DeltaDrawing>()) {
    const DeltaModel<double>& model = delta->settings;
    Vec3<double> motors_mm = DeltaMotors_mm(model, q_mm);
    for (int i = 0; i < kNumTowers; ++i) {
      const double steps_per_mm =
          config_.machine.axes[static_cast<std::size_t>(i)].steps_per_mm();
      motors_mm[i] = std::round(motors_mm[i] * steps_per_mm) / steps_per_mm;
    }
    return DeltaNozzle_mm(model, motors_mm);
  }
  const DriveMap* drives = config_.machine.kind->drive_map();
  Vec3<double> homes_mm;
  for (const Axis axis : kAxes) {
    homes_mm[Index(axis)] = config_.machine.axis(axis).home_mm();
  }
  homes_mm = DrivesOf(drives, homes_mm);
  Vec3<double> reached_mm = DrivesOf(drives, q_mm);
  for (int i = 0; i < 3; ++i) {
    const double home_mm = homes_mm[i];
    const double steps_per_mm = settings.steps_per_mm[static_cast<std::size_t>(i)];
    reached_mm[i] =
        home_mm + std::round((reached_mm[i] - home_mm) * steps_per_mm) / steps_per_mm;
  }
  return AxesOf(drives, reached_mm);
}

double Readings::Shown_mm(const Row& row,
                          const At& at,
                          double value_mm,
                          double scatter_mm) {
  if (!config_.is_noisy) return value_mm;
  const Instrument& instrument = InstrumentFor(row);
  value_mm += MmFromUm(instrument.sigma_um) * noise_.Normal();
  if (row.kind == RowKind::kTouch) {
    value_mm += scatter_mm * scatter_.Normal();
    const Vec3<double> axes_mm = WithValue(at, row, value_mm).q_mm;
    value_mm += (Reachable_mm(axes_mm, SettingsFor(row)) - axes_mm).dot(at.n);
  }
  const double step_mm = MmFromUm(instrument.resolution_um);
  return step_mm > 0 ? std::round(value_mm / step_mm) * step_mm : value_mm;
}

}  // namespace caltwin
