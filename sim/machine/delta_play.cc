#include "sim/machine/delta_play.h"

#include <algorithm>

#include "sim/base/require.h"
#include "sim/machine/delta_slopes.h"

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
  Require(machine.delta.has_value(), "the machine is a delta");
  const auto closed = ClosedDelta::At(build, motors_mm);
  if (!closed) return std::nullopt;
  const auto rises = closed->Slopes(Unit(Axis::kZ));
  DeltaBuild<double> taken = build;
  for (int i = 0; i < kNumTowers; ++i) {
    const auto tower = static_cast<std::size_t>(i);
    const double rise = rises[tower + kEndstopKnob];
    const AxisDrawing& drawing = machine.axes[tower];
    const bool is_held =
        TowerLoad_n(drawing, *machine.delta, rise) < drawing.rail_friction_n;
    const double sense = is_held ? motor_dir[i] : -1;
    taken.model.endstop_mm[tower] += sense * gaps_mm[tower] / 2;
  }
  return taken;
}

}  // namespace caltwin
