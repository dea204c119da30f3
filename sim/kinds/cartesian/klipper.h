#pragma once

#include <string>

#include "sim/controllers/klipper/printer_cfg.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// The motor of an axis, without what its rail is, as its firmware believes.
klipper::StepperText StepperOf(const Machine& machine,
                               Axis axis,
                               std::string section,
                               std::string pin);

/// The printer.cfg of a machine that WiringOfGantry wires, with what its firmware
/// believes: steps per mm, the probe's height at its trigger as drawn, a mesh over most
/// of the table.
std::string PrinterCfgOfGantry(const Machine& machine, const std::string& serial);

}  // namespace caltwin
