#include "sim/kinds/triple_z/plant.h"

#include <cmath>

#include "sim/base/input_error.h"
#include "sim/effects/predict.h"
#include "sim/effects/surroundings.h"
#include "sim/kinds/perform.h"
#include "sim/machine/kinds/triple_z/drawing.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

// The touch of the bed's nominal point, as a row has it: coming from below.
Row TouchRow(const Machine& machine,
             const Vec3<double>& raised_mm,
             const Eigen::Vector2d& at_mm) {
  Row row{.kind = RowKind::kTouch};
  row.cmd_mm = {at_mm[0], at_mm[1], 0};
  row.n = {0, 0, 1};
  row.dir = {0, 0, -1};
  row.feed_mm_s = machine.probe.speeds_mm_s.back();
  row.feature = "bed.top";
  const ScrewCells screws = ScrewCellsOf(&row, machine.kind->drive_map() != nullptr);
  for (int i = 0; i < kNumScrews; ++i) {
    (*screws.mm)[static_cast<std::size_t>(i)] =
        TripleZOf(machine).top_mm + raised_mm[i];
  }
  screws.dir->fill(1);
  return row;
}

}  // namespace

TripleZTwinPlant::TripleZTwinPlant(const BuiltTripleZ& built,
                                   bool is_physics,
                                   std::uint64_t seed,
                                   std::uint64_t sample)
    : built_(built), scatter_(seed, sample, "trigger_scatter") {
  if (is_physics) {
    machine_ = std::make_unique<TripleZMachine>(built.machine, built.effects);
  }
}

std::optional<double> TripleZTwinPlant::Touch(const Vec3<double>& raised_mm,
                                              double x_mm,
                                              double y_mm) {
  const Machine& machine = built_.machine;
  const Row row = TouchRow(machine, raised_mm, {x_mm, y_mm});
  const At at = AtOf(row, machine, machine.settings);
  double height_mm = ClosedFormTouch_mm(machine, built_.effects, row, at);
  if (machine_) {
    try {
      height_mm = machine_->Touch_mm(row, at);
    } catch (const InputError&) {
      return std::nullopt;
    }
  }
  const double variance_mm2 = built_.scatter_mm * built_.scatter_mm +
                              ErrorsAt<double>(machine, at, built_.effects).scatter_mm2;
  return height_mm + std::sqrt(variance_mm2) * scatter_.Normal();
}

double TrueBedHeight_mm(const BuiltTripleZ& built,
                        const Vec3<double>& raised_mm,
                        const Eigen::Vector2d& at_mm) {
  const Row row = TouchRow(built.machine, raised_mm, at_mm);
  return ClosedFormTouch_mm(built.machine,
                            built.effects,
                            row,
                            AtOf(row, built.machine, built.machine.settings));
}

}  // namespace caltwin
