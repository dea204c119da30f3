#pragma once

#include <vector>

#include "sim/controllers/linuxcnc/config.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// The joints X, Y, Z of a machine that WiringOfGantry wires, with what its firmware
/// believes: steps per mm and play. Throws InputError for belts.
std::vector<linuxcnc::JointText> LinuxCncJointsOfGantry(const Machine& machine);

}  // namespace caltwin
