#include "sim/kinds/delta/linuxcnc.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {

linuxcnc::MachineText LinuxCncOfDelta(const Machine& machine) {
  /// A nozzle may have to look for the bed below where the drawing has it.
  constexpr double kBelowBed_mm = 8, kBeyondSwitch_mm = 1;
  constexpr std::array kTowers = {2, 0, 1};
  const DeltaDrawing& delta = DeltaOf(machine);
  const double arm_mm = MeanOfTowers(delta.settings.arm_mm);
  const double radius_mm = MeanOfTowers(delta.settings.radius_mm);
  const double rise_mm = std::sqrt(arm_mm * arm_mm - radius_mm * radius_mm);
  const double top_mm = std::ranges::min(delta.settings.endstop_mm);
  const std::array<double, 3> steps_per_mm = TowerStepsPerMm(machine);
  linuxcnc::MachineText text{.name = machine.name,
                             .kinematics = "lineardeltakins",
                             .sizes = {{"L", arm_mm}, {"R", radius_mm}}};
  const AxisDrawing& slowest =
      *std::ranges::min_element(machine.axes, {}, &AxisDrawing::max_feed_mm_s);
  for (const char letter : {'X', 'Y', 'Z'}) {
    const bool is_z = letter == 'Z';
    text.axes.push_back({.letter = letter,
                         .min_mm = is_z ? -kBelowBed_mm : -delta.print_radius_mm,
                         .max_mm = is_z ? top_mm : delta.print_radius_mm,
                         .max_feed_mm_s = slowest.max_feed_mm_s,
                         .acceleration_mm_s2 = slowest.acceleration_mm_s2});
  }
  for (const int tower : kTowers) {
    const auto at = static_cast<std::size_t>(tower);
    const AxisDrawing& drawn = machine.axes[at];
    const double home_mm = delta.settings.endstop_mm[at] + rise_mm;
    text.joints.push_back({.motor = tower,
                           .min_mm = -kBelowBed_mm,
                           .max_mm = home_mm + kBeyondSwitch_mm,
                           .home_mm = home_mm,
                           .is_home_at_min = false,
                           .max_feed_mm_s = drawn.max_feed_mm_s,
                           .acceleration_mm_s2 = drawn.acceleration_mm_s2,
                           .steps_per_mm = steps_per_mm[at],
                           .steps_per_turn = machine.axes[at].full_steps_per_rev *
                                             machine.axes[at].microsteps});
  }
  return text;
}

}  // namespace caltwin
