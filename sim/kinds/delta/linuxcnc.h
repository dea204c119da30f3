#pragma once

#include "sim/controllers/linuxcnc/config.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// A delta that WiringOfDelta wires, by `lineardeltakins`, with what its firmware
/// believes. Those know one arm and one radius for all towers, of several their mean,
/// and towers at 90, 210 and 330 deg: joints 0, 1, 2 are c, a, b. A joint stands as
/// high as its carriage: endstop plus what the arm rises.
linuxcnc::MachineText LinuxCncOfDelta(const Machine& machine);

}  // namespace caltwin
