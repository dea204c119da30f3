#pragma once

#include <string>

#include "sim/measure/import/printer_cfg.h"

namespace caltwin {

/// The machine file of the printer that a Klipper configuration is for, as that has it:
/// kinematics, travels, motors, where its screws or its gantry's corners are, a delta's
/// geometry. Kinds: delta, cartesian, corexy; on three motors of Z with [z_tilt] its
/// bed stands on screws, a CoreXY on four with [quad_gantry_level] hangs on them.
/// Throws InputError: it does not say so much, or is of another kind.
std::string MachineFileOf(const PrinterCfg& cfg, const std::string& name);

}  // namespace caltwin
