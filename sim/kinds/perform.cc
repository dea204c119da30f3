#include "sim/kinds/perform.h"

#include <cmath>
#include <optional>
#include <utility>

#include "sim/effects/gap_sense.h"
#include "sim/effects/predict.h"
#include "sim/kinds/readings.h"
#include "sim/kinds/triple_z/machine.h"
#include "sim/kinds/z_station/machine.h"
#include "sim/machine/kinds/kinds.h"
#include "sim/machine/kinds/triple_z/drawing.h"
#include "sim/machine/machine_kind.h"
#include "sim/twin/measuring_machine.h"

namespace caltwin {
namespace {

constexpr int kMostRounds = 200;
constexpr int kPlainRounds = 10;
constexpr double kSolved_mm = 1e-12;
constexpr double kUpright = 0.5;
constexpr double kStandIn_mm = 1;

// The closed form knows how far an axis has crossed its gap by the sense alone.
At InGap(const PerformConfig& config, At at) {
  at.dir =
      GapSense(at, ErrorsAt<double>(config.machine, at, config.effects).lost_motion_mm);
  return at;
}

// Takes one row's reading, before chance and counting.
class Reader {
 public:
  explicit Reader(const PerformConfig& config) : config_(config) {
    const bool is_physics = config.fidelity == Fidelity::kPhysics;
    if (config.machine.kind == ZStationKind()) {
      station_.emplace(config.machine, config.effects, is_physics);
      return;
    }
    if (!is_physics) return;
    const bool is_on_screws = config.machine.Own<TripleZDrawing>() != nullptr;
    if (is_on_screws) triple_z_.emplace(config.machine, config.effects);
    const bool moves_belts = config.machine.kind->drive_map() != nullptr;
    if (is_on_screws && !moves_belts) return;
    Machine moved = config.machine;
    // A nozzle is no ball; where it stands, nothing is touched by this one.
    if (is_on_screws) moved.probe.tip_radius_mm = kStandIn_mm;
    machine_.emplace(moved, config.effects);
  }

  double Position_mm(const Row& row, const At& at) {
    if (station_) return station_->Reading_mm(row, at);
    // Across the bed belts move the head; towards it screws the bed.
    if (triple_z_ && (!machine_ || std::abs(at.n[2]) > kUpright)) {
      return triple_z_->Gauge_mm(at);
    }
    if (machine_) return machine_->Position_mm(at);
    return Predict_mm<double>(config_.machine, InGap(config_, at), config_.effects);
  }

  double Touch_mm(const Row& row, At at) {
    if (station_) return station_->Reading_mm(row, at);
    if (triple_z_) return triple_z_->Touch_mm(row, at);
    if (machine_) return machine_->Touch_mm(row, at);
    at = InGap(config_, at);
    // A release comes at a smaller deflection.
    return ClosedFormTouch_mm(config_.machine, config_.effects, row, at) +
           (IsRelease(row) ? config_.machine.probe.hysteresis_mm : 0);
  }

 private:
  const PerformConfig& config_;
  std::optional<MeasuringMachine> machine_{};
  std::optional<TripleZMachine> triple_z_{};
  std::optional<ZStationMachine> station_{};
};

double Reading_mm(const PerformConfig& config,
                  const Row& row,
                  Reader* reader,
                  Readings* readings) {
  At at = readings->AtFor(row);
  if (row.kind == RowKind::kTouch) {
    const double value_mm = reader->Touch_mm(row, at);
    at = Readings::WithValue(at, row, value_mm);
    const double scatter_mm =
        std::sqrt(ErrorsAt<double>(config.machine, at, config.effects).scatter_mm2);
    return readings->Shown_mm(row, at, value_mm, scatter_mm);
  }
  // The motors stand on whole steps, wherever they were told to go.
  const Vec3<double> told_mm = at.q_mm;
  if (config.is_noisy) {
    at.q_mm = readings->Reachable_mm(told_mm, readings->SettingsFor(row));
  }
  const double off_mm = (at.q_mm - told_mm).dot(at.n);
  return readings->Shown_mm(row, at, off_mm + reader->Position_mm(row, at), 0);
}

}  // namespace

// Halved steps once plain ones do not settle: steep waves.
double ClosedFormTouch_mm(const Machine& machine,
                          std::span<const Injected> effects,
                          const Row& row,
                          At at) {
  double value_mm = 0;
  for (int i = 0; i < kMostRounds; ++i) {
    at = Readings::WithValue(at, row, value_mm);
    const double next_mm = Predict_mm<double>(machine, at, effects);
    const double step_mm = next_mm - value_mm;
    value_mm += i < kPlainRounds ? step_mm : step_mm / 2;
    if (std::abs(step_mm) < kSolved_mm) break;
  }
  return value_mm;
}

RowTable Perform(const PerformConfig& config, std::vector<Row> planned) {
  Readings readings(config, planned);
  Reader reader(config);
  RowTable table;
  for (Row& row : planned) {
    if (table.rows.size() >= config.already_read) {
      if (config.interrupted && config.interrupted()) break;
      row.value_mm = Reading_mm(config, row, &reader, &readings);
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

}  // namespace caltwin
