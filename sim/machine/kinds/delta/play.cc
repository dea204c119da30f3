#include "sim/machine/kinds/delta/play.h"

#include <algorithm>

#include "sim/base/require.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/delta/knobs.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/kinds/delta/slopes.h"

namespace caltwin {

bool HasPlay(const CarriageGaps_mm& gaps_mm) {
  return std::ranges::any_of(gaps_mm, [](double gap_mm) { return gap_mm > 0; });
}

std::optional<DeltaBuild<double>> WithPlayTaken(const DeltaBuild<double>& build,
                                                const Machine& machine,
                                                const CarriageGaps_mm& gaps_mm,
                                                const Vec3<double>& motors_mm,
                                                const Vec3<double>& motor_dir) {
  if (!HasPlay(gaps_mm)) return build;
  Require(machine.Own<DeltaDrawing>() != nullptr, "the machine is a delta");
  const auto closed = ClosedDelta::At(build, motors_mm);
  if (!closed) return std::nullopt;
  const auto rises = closed->Slopes(Unit(Axis::kZ));
  DeltaBuild<double> taken = build;
  for (std::size_t i = 0; i < kNumTowers; ++i) {
    const AxisDrawing& drawing = machine.axes[i];
    const bool is_held =
        TowerLoad_n(drawing, DeltaOf(machine), rises[i + kEndstopKnob]) <
        drawing.rail_friction_n;
    const double sense = is_held ? motor_dir[static_cast<Eigen::Index>(i)] : -1.0;
    taken.model.endstop_mm[i] += sense * gaps_mm[i] / 2.0;
  }
  return taken;
}

}  // namespace caltwin
