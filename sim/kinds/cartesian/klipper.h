#pragma once

#include <string>

#include "sim/machine/machine.h"

namespace caltwin {

/// The printer.cfg of a machine that WiringOfGantry wires, with what its firmware
/// believes: steps per mm, the probe's height at its trigger as drawn, a mesh over most
/// of the table.
std::string PrinterCfgOfGantry(const Machine& machine, const std::string& serial);

}  // namespace caltwin
