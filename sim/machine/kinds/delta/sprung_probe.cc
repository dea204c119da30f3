#include "sim/machine/kinds/delta/sprung_probe.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/delta/knobs.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/kinds/delta/slopes.h"

namespace caltwin {
namespace {

// By how much the nozzle rises as each carriage does, at this pose.
std::optional<std::array<double, 3>> Rises(const DeltaBuild<double>& build,
                                           const Vec3<double>& motors_mm) {
  const auto closed = ClosedDelta::At(build, motors_mm);
  if (!closed) return std::nullopt;
  const auto slopes = closed->Slopes(Unit(Axis::kZ));
  return std::array{
      slopes[kEndstopKnob], slopes[kEndstopKnob + 1], slopes[kEndstopKnob + 2]};
}

// How far the drives go down until the nozzle has by `down_mm`, while these carriages
// stand until their gaps are crossed.
double DriveDown_mm(std::vector<std::pair<double, double>> gaps_and_rises,
                    double down_mm) {
  std::ranges::sort(gaps_and_rises);
  double drive_mm = 0, slope = 1;
  for (const auto& [gap_mm, rise] : gaps_and_rises) slope -= rise;
  for (const auto& [gap_mm, rise] : gaps_and_rises) {
    const double within_mm = slope * (gap_mm - drive_mm);
    if (slope > 0 && within_mm >= down_mm) return drive_mm + down_mm / slope;
    down_mm -= within_mm;
    drive_mm = gap_mm;
    slope += rise;
  }
  return drive_mm + down_mm;
}

// How far at most a carriage coasts that comes down at the speed of a touch and is
// stopped by so much force: three times v^2 / 2 m / force, for the chain moves with it.
double Coast_mm(double weight_n, double stops_n) {
  constexpr double kTouch_mm_s = 5, kSure = 3, kGravity_mm_s2 = 9810;
  return kSure * kTouch_mm_s * kTouch_mm_s / (2 * kGravity_mm_s2) * weight_n / stops_n;
}

[[noreturn]] void FailOpen(std::size_t tower, double gap_mm, double pretravel_mm) {
  throw InputError(
      {},
      fmt::format("carriage {} stops in its play of {:g} mm when the probe touches; "
                  "whether that is crossed when the probe triggers, {:g} mm on, its "
                  "speed decides, which closed form does not know",
                  TowerName(static_cast<int>(tower)),
                  gap_mm,
                  pretravel_mm),
      "fidelity: physics, or a longer pre-travel");
}

}  // namespace

std::optional<DeltaBuild<double>> WithPlayTakenByProbe(const DeltaBuild<double>& build,
                                                       const Machine& machine,
                                                       const CarriageGaps_mm& gaps_mm,
                                                       const Vec3<double>& motors_mm,
                                                       double pretravel_mm) {
  auto taken = WithPlayTaken(build, machine, gaps_mm, motors_mm, Vec3<double>::Ones());
  if (!taken || !HasPlay(gaps_mm)) return taken;
  const auto rises = Rises(build, motors_mm);
  if (!rises) return std::nullopt;
  std::vector<std::size_t> lifted;
  std::vector<std::pair<double, double>> gaps_and_rises;
  double coast_mm = 0, fall_mm = 0;
  for (std::size_t i = 0; i < kNumTowers; ++i) {
    const AxisDrawing& drawing = machine.axes[i];
    const double hanging_n = TowerLoad_n(drawing, DeltaOf(machine), (*rises)[i]);
    const double pushed_n = hanging_n - kProbePreload_n * (*rises)[i];
    if (gaps_mm[i] <= 0 || hanging_n < drawing.rail_friction_n ||
        pushed_n >= drawing.rail_friction_n) {
      continue;
    }
    lifted.push_back(i);
    gaps_and_rises.emplace_back(gaps_mm[i], (*rises)[i]);
    const double coast = Coast_mm(hanging_n, drawing.rail_friction_n - pushed_n);
    coast_mm = std::max(coast_mm, coast);
    fall_mm += coast * (*rises)[i];
  }
  if (lifted.empty()) return taken;
  const double drive_mm =
      DriveDown_mm(std::move(gaps_and_rises), pretravel_mm - fall_mm) - coast_mm;
  for (const std::size_t i : lifted) {
    if (drive_mm < gaps_mm[i]) FailOpen(i, gaps_mm[i], pretravel_mm);
    taken->model.endstop_mm[i] += gaps_mm[i];
  }
  return taken;
}

}  // namespace caltwin
