#pragma once

#include "sim/controllers/linuxcnc/config.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// The axes X, Y, Z, joints too, of a machine that WiringOfGantry wires, with what its
/// firmware believes: steps per mm and play. Joints of a beam with two motors: X, Y, Y,
/// Z. Throws InputError for belts.
linuxcnc::MachineText LinuxCncOfGantry(const Machine& machine);

}  // namespace caltwin
