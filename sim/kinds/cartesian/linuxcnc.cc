#include "sim/kinds/cartesian/linuxcnc.h"

#include "sim/base/input_error.h"
#include "sim/machine/kinds/cartesian/drawing.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {

linuxcnc::MachineText LinuxCncOfGantry(const Machine& machine) {
  /// A probe may have to look for the table below where the drawing has it.
  constexpr double kBelowTable_mm = 5;
  if (machine.kind->drive_map() != nullptr) {
    throw InputError(
        {.file = machine.name},
        "under LinuxCNC every motor moves an axis of its own, not yet belts "
        "that two share",
        "take a machine of kind cartesian, such as gantry_router");
  }
  linuxcnc::MachineText text{.name = machine.name};
  const auto add_joint = [&](Axis axis, int motor, int home_sequence) {
    const auto at = static_cast<std::size_t>(Index(axis));
    const AxisDrawing& drawn = machine.axis(axis);
    text.joints.push_back(
        {.motor = motor,
         .min_mm = axis == Axis::kZ ? drawn.min_mm - kBelowTable_mm : drawn.min_mm,
         .max_mm = drawn.max_mm,
         .home_mm = drawn.home_mm(),
         .is_home_at_min = drawn.home == HomeEnd::kMin,
         .home_sequence = home_sequence,
         .max_feed_mm_s = drawn.max_feed_mm_s,
         .acceleration_mm_s2 = drawn.acceleration_mm_s2,
         .steps_per_mm = machine.settings.steps_per_mm[at],
         .steps_per_turn = drawn.full_steps_per_rev * drawn.microsteps,
         .backlash_mm = machine.settings.backlash_mm[at]});
  };
  const bool has_beam = machine.Own<BeamDrawing>() != nullptr;
  for (const Axis axis : kAxes) {
    const AxisDrawing& drawn = machine.axis(axis);
    const bool is_z = axis == Axis::kZ, is_beam = has_beam && axis == Axis::kY;
    text.axes.push_back({.letter = CapitalLetter(axis),
                         .min_mm = is_z ? drawn.min_mm - kBelowTable_mm : drawn.min_mm,
                         .max_mm = drawn.max_mm,
                         .max_feed_mm_s = drawn.max_feed_mm_s,
                         .acceleration_mm_s2 = drawn.acceleration_mm_s2});
    add_joint(axis, Index(axis), is_z ? 0 : is_beam ? -2 : 1);
    if (is_beam) add_joint(axis, /*motor=*/3, -2);
  }
  if (has_beam) {
    text.coordinates = "XYYZ";
    text.kinematics = "trivkins coordinates=XYYZ kinstype=BOTH";
  }
  return text;
}

}  // namespace caltwin
