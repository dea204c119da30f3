#include "scenarios/kinds/triple_z_wire.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "scenarios/position_error.h"
#include "sim/base/rng.h"
#include "sim/effects/predict.h"
#include "sim/effects/surroundings.h"
#include "sim/machine/kinds/triple_z/drawing.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

// The nozzle over the bed less where it was sent to.
Vec3<double> OffAt_mm(const BuiltTripleZ& built,
                      const Vec3<double>& raised_mm,
                      const Vec3<double>& sent_mm,
                      double sense) {
  const Machine& machine = built.machine;
  Row row{.kind = RowKind::kPosition};
  row.cmd_mm = {sent_mm[0], sent_mm[1], sent_mm[2]};
  row.n = {0, 0, 1};
  row.dir = {0, 0, sense};
  row.feature = "bed.top";
  const ScrewCells screws = ScrewCellsOf(&row, machine.kind->drive_map() != nullptr);
  for (std::size_t i = 0; i < screws.mm->size(); ++i) {
    (*screws.mm)[i] = TripleZOf(machine).top_mm - sent_mm[2] +
                      raised_mm[static_cast<Eigen::Index>(i)];
  }
  screws.dir->fill(-sense);
  const At at = AtOf(row, machine, machine.settings);
  const auto errors = ErrorsAt<double>(machine, at, built.effects);
  return errors.motion_mm - errors.artefact_mm * Unit(Axis::kZ);
}

}  // namespace

double TripleZPositionP95_mm(const BuiltTripleZ& built, const Vec3<double>& raised_mm) {
  constexpr int kPoses = 1000;
  Rng rng(1, 0, "position_error_mm");
  std::vector<Vec3<double>> errors_mm;
  for (int pose = 0; pose < kPoses; ++pose) {
    Vec3<double> sent_mm;
    for (const Axis axis : kAxes) {
      const AxisDrawing& drawing = built.machine.axis(axis);
      sent_mm[Index(axis)] = drawing.min_mm + drawing.travel_mm() * rng.Uniform();
    }
    for (const double sense : {1.0, -1.0}) {
      errors_mm.push_back(OffAt_mm(built, raised_mm, sent_mm, sense));
    }
  }
  return P95AboutMean_mm(errors_mm);
}

TrueLevel TrueLevelOf(const BuiltTripleZ& built,
                      const Vec3<double>& raised_mm,
                      double reference_mm) {
  constexpr int kSide = 11;
  constexpr double kMargin_mm = 20;
  const auto along = [&](Axis axis, int i) {
    const AxisDrawing& drawing = built.machine.axis(axis);
    return drawing.min_mm + kMargin_mm +
           (drawing.travel_mm() - 2 * kMargin_mm) * i / (kSide - 1);
  };
  Eigen::ArrayXd heights_mm(kSide * kSide);
  for (int i = 0; i < kSide * kSide; ++i) {
    heights_mm[i] = TrueBedHeight_mm(
        built, raised_mm, {along(Axis::kX, i % kSide), along(Axis::kY, i / kSide)});
  }
  const Eigen::ArrayXd off_mm = (heights_mm - reference_mm).abs();
  return {.mean_mm = off_mm.mean(),
          .max_mm = off_mm.maxCoeff(),
          .flat_rms_mm = std::sqrt((heights_mm - heights_mm.mean()).square().mean())};
}

}  // namespace caltwin
