#include "sim/kinds/delta/perform.h"

#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "sim/effects/catalog.h"
#include "sim/effects/drive.h"
#include "sim/effects/kinds/delta_at.h"
#include "sim/effects/linkage_at.h"
#include "sim/effects/predict.h"
#include "sim/kinds/readings.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {
namespace {

[[noreturn]] void FailReach(const Row& row) {
  throw InputError(
      row.place,
      fmt::format("row {}: the rods of this machine do not reach there", row.row),
      "choose a smaller radius or height");
}

class DeltaReader {
 public:
  explicit DeltaReader(const DeltaPerformConfig& config)
      : config_(config), settings_(DeltaOf(config.machine).settings) {
    if (config.fidelity == Fidelity::kPhysics) {
      world_ = std::make_unique<DeltaWorld>(WorldOfDelta(config.machine, config.built));
    }
  }

  double Gauge_mm(const Row& row, At at) {
    LinkageAt delta = Placed(row, at.q_mm);
    if (world_) delta.off_mm = Settled_mm(row, delta) - at.q_mm;
    at.linkage = &delta;
    at.rim_mm = config_.built.bed.radius_mm;
    return Predict_mm<double>(config_.machine, at, config_.effects);
  }

  // The reading at which the nozzle is where the bed is; what else moves nozzle,
  // carriages or bed is little, and added to first order.
  double Touch_mm(const Row& row, At at) {
    const double contact_mm = Contact_mm(row, at.q_mm);
    at.q_mm[2] += contact_mm;
    LinkageAt delta = Placed(row, at.q_mm);
    delta.off_mm.setZero();
    at.linkage = &delta;
    at.rim_mm = config_.built.bed.radius_mm;
    // What gives way before the trigger is in the contact already.
    return contact_mm + Predict_mm<double>(config_.machine, at, config_.effects) +
           config_.machine.probe.pretravel_mm;
  }

 private:
  // Of the build alone, above the nominal point.
  double Contact_mm(const Row& row, const Vec3<double>& sent_mm) {
    const auto touched_mm = TouchOfDelta_mm(
        world_.get(), config_.machine, config_.built, settings_, sent_mm.head<2>());
    if (!touched_mm) FailReach(row);
    return *touched_mm - sent_mm[2];
  }

  // Where MuJoCo's effector comes to rest.
  Vec3<double> Settled_mm(const Row& row, const LinkageAt& delta) {
    const auto rest_mm = RestInPhysics(
        world_.get(), config_.built.build, delta.motors_mm, delta.motor_dir);
    if (!rest_mm) FailReach(row);
    return *rest_mm;
  }

  LinkageAt Placed(const Row& row, const Vec3<double>& q_mm) const {
    auto placed = LinkageAtOf(config_.built.build, settings_, row, q_mm);
    if (!placed) FailReach(row);
    return *placed;
  }

  const DeltaPerformConfig& config_;
  const DeltaModel<double>& settings_;
  std::unique_ptr<DeltaWorld> world_{};
};

double Reading_mm(const DeltaPerformConfig& config,
                  const Row& row,
                  Readings* readings,
                  DeltaReader* reader) {
  At at = readings->AtFor(row);
  if (row.kind == RowKind::kTouch) {
    return readings->Shown_mm(
        row, at, reader->Touch_mm(row, at), config.built.scatter_mm);
  }
  const Vec3<double> told_mm = at.q_mm;
  if (config.is_noisy) {
    at.q_mm = readings->Reachable_mm(told_mm, readings->SettingsFor(row));
  }
  const double off_mm = (at.q_mm - told_mm).dot(at.n);
  return readings->Shown_mm(row, at, off_mm + reader->Gauge_mm(row, at), 0);
}

}  // namespace

RowTable PerformDelta(const DeltaPerformConfig& as_given, std::vector<Row> planned) {
  DeltaPerformConfig config = as_given;
  config.effects = TurnBuild(as_given.effects, &config.built.build);
  if (config.fidelity == Fidelity::kPhysics) {
    BuildPlayIn(&config.effects, &config.built);
  }
  // The heights of a bed's shapes are those of the outermost touch.
  const double rim_mm = RimOf_mm(planned);
  if (rim_mm > 0) config.built.bed.radius_mm = rim_mm;
  const PerformConfig common{.machine = config.machine,
                             .effects = config.effects,
                             .header = config.header,
                             .seed = config.seed,
                             .is_noisy = config.is_noisy};
  Readings readings(common, planned);
  DeltaReader reader(config);
  RowTable table;
  for (Row& row : planned) {
    if (table.rows.size() >= config.already_read) {
      if (config.interrupted && config.interrupted()) break;
      row.value_mm = Reading_mm(config, row, &readings, &reader);
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

}  // namespace caltwin
