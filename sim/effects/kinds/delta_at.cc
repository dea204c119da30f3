#include "sim/effects/kinds/delta_at.h"

#include <algorithm>
#include <cmath>

#include "sim/effects/linkage_at.h"
#include "sim/machine/kinds/delta/knobs.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/kinds/delta/slopes.h"

namespace caltwin {

double RimOf_mm(const std::vector<Row>& rows) {
  double rim_mm = 0;
  for (const Row& row : rows) {
    const double out_mm = std::hypot(row.cmd_mm[0], row.cmd_mm[1]);
    if (row.kind == RowKind::kTouch && Known(out_mm)) rim_mm = std::max(rim_mm, out_mm);
  }
  return rim_mm;
}

std::optional<LinkageAt> LinkageAtOf(const DeltaBuild<double>& build,
                                     const DeltaModel<double>& settings,
                                     const Row& row,
                                     const Vec3<double>& q_mm) {
  LinkageAt here{.motors_mm = DeltaMotors_mm(settings, q_mm)};
  const Vec3<double> stated(row.motor_mm[0], row.motor_mm[1], row.motor_mm[2]);
  const Vec3<double> nominal(row.cmd_mm[0], row.cmd_mm[1], row.cmd_mm[2]);
  if (stated.allFinite() && nominal.allFinite()) {
    here.motors_mm += stated - DeltaMotors_mm(settings, nominal);
  }
  if (!here.motors_mm.allFinite()) return std::nullopt;
  for (int k = 0; k < kNumTowers; ++k) {
    const double dir = row.motor_dir[static_cast<std::size_t>(k)];
    here.motor_dir[k] = Known(dir) ? dir : 0;
  }
  const auto closed = ClosedDelta::At(build, here.motors_mm);
  if (!closed) return std::nullopt;
  here.off_mm = closed->pose().nozzle_mm - q_mm;
  for (const Axis axis : kAxes) {
    const auto slopes = closed->Slopes(Unit(axis));
    here.by_knob.row(Index(axis)) =
        Eigen::Map<const Eigen::Matrix<double, 1, kNumDeltaKnobs>>(slopes.data());
  }
  return here;
}

}  // namespace caltwin
