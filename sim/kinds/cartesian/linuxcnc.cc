#include "sim/kinds/cartesian/linuxcnc.h"

#include "sim/base/input_error.h"
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
  for (const Axis axis : kAxes) {
    const auto at = static_cast<std::size_t>(Index(axis));
    const AxisDrawing& drawn = machine.axis(axis);
    const bool is_z = axis == Axis::kZ;
    const double min_mm = is_z ? drawn.min_mm - kBelowTable_mm : drawn.min_mm;
    text.axes.push_back({.letter = CapitalLetter(axis),
                         .min_mm = min_mm,
                         .max_mm = drawn.max_mm,
                         .max_feed_mm_s = drawn.max_feed_mm_s,
                         .acceleration_mm_s2 = drawn.acceleration_mm_s2});
    text.joints.push_back({.motor = Index(axis),
                           .min_mm = min_mm,
                           .max_mm = drawn.max_mm,
                           .home_mm = drawn.home_mm(),
                           .is_home_at_min = drawn.home == HomeEnd::kMin,
                           .home_sequence = is_z ? 0 : 1,
                           .max_feed_mm_s = drawn.max_feed_mm_s,
                           .acceleration_mm_s2 = drawn.acceleration_mm_s2,
                           .steps_per_mm = machine.settings.steps_per_mm[at],
                           .backlash_mm = machine.settings.backlash_mm[at]});
  }
  return text;
}

}  // namespace caltwin
