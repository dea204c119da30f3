#include "scenarios/kinds/z_station_klipper_trial.h"

#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/kinds/z_station/klipper.h"
#include "sim/machine/kinds/z_station/drawing.h"

namespace caltwin {
namespace {

constexpr double kRecovered_mm = 0.01;
constexpr double kCommanded_mm = 5;

}  // namespace

std::optional<double> ZStationKlipperTrial::NozzleOverBed_mm(const Motors& steps) {
  Vec3<double> at_mm = InPlant(WiringOfStation(machine_), steps);
  for (const Axis axis : kAxes) {
    at_mm[Index(axis)] /= machine_.axis(axis).steps_per_mm();
    if (axis != Axis::kZ) at_mm[Index(axis)] += machine_.axis(axis).home_mm();
  }
  return twin_.Gap_mm(at_mm[2], at_mm.head<2>());
}

void ZStationKlipperTrial::Finish(RunResult* result) {
  KlipperTrial::Finish(result);
  const Eigen::Vector2d& at_mm = twin_.middle_mm();
  const auto steps =
      MotorsAfter({"G90",
                   fmt::format("G1 Z{} F600", kCommanded_mm),
                   fmt::format("G1 X{:.3f} Y{:.3f} F3000", at_mm[0], at_mm[1]),
                   "M400"});
  if (!steps) return;
  error_mm_ = *NozzleOverBed_mm(*steps) - kCommanded_mm;
  result->position_error_after_p95_mm = std::abs(*error_mm_);
  result->position_error_before_p95_mm = std::abs(*error_mm_);
  result->is_error_of_nozzle = true;
}

void ZStationKlipperTrial::AddParameters(const Expectation& /*expect*/,
                                         const std::vector<ProcedureResult>& /*done*/,
                                         RunResult* result) {
  ParameterResult row{.name = "z_offset_error", .unit = "mm", .is_setting = true};
  row.identifiable = error_mm_.has_value();
  row.recovered = row.error = error_mm_;
  result->parameters.push_back(row);
}

TrueEnd ZStationKlipperTrial::End(const std::vector<ProcedureResult>& /*results*/,
                                  RunResult* result) {
  if (!error_mm_) {
    result->messages.emplace_back(
        "the host does not go there: no height is known of the nozzle");
    return {.told_wrong = true};
  }
  result->messages.push_back(fmt::format(
      "told to go {} mm over the middle of the bed the clean nozzle stands {:+.4f} mm "
      "off that",
      kCommanded_mm,
      *error_mm_));
  const double off_mm = std::abs(*error_mm_);
  return {.figure = TrueFigure{
              .before = off_mm, .after = off_mm, .is_met = off_mm <= kRecovered_mm}};
}

double ZStationKlipperTrial::Figure(const std::string& name, const RunResult&) {
  if (name == "z_offset_error_mm" && error_mm_) return std::abs(*error_mm_);
  return std::numeric_limits<double>::quiet_NaN();
}

std::unique_ptr<KindTrial> BeginStationUnderKlipper(const ZStationScenario& z,
                                                    const Scenario& scenario,
                                                    const Chance& chance) {
  const Machine& machine = scenario.machine.machine;
  const bool is_physics = chance.fidelity == Fidelity::kPhysics;
  ZStation station;
  SetStation(z.station, chance.seed, chance.sample, &station);
  auto board = std::make_unique<PlantBoard>(
      WiringOfStation(machine),
      std::make_unique<SteppedStation>(machine, station, is_physics, chance.seed));
  KlipperHostOptions options = *scenario.klipper;
  if (options.config.empty()) options.config = PrinterCfgOfStation(machine, "-");
  return std::make_unique<ZStationKlipperTrial>(
      machine,
      ZStationTwin(station,
                   is_physics,
                   chance.seed,
                   chance.sample,
                   ZStationOf(machine).bed_at_mm),
      std::move(board),
      std::move(options),
      chance);
}

}  // namespace caltwin
