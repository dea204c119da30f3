#pragma once

#include <string>

#include "sim/controllers/plant_board.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// How a printer whose bed stands on three screws is wired to a Klipper board: motors
/// X, Y (of belts: the two), Z, Z1, Z2, each with an endstop of its name (X_STOP); the
/// screws' at their lower ends. The nozzle that feels the bed is on PROBE. When it is
/// switched on the bed stands askew near its lower end.
Wiring WiringOfTripleZ(const Machine& machine);

/// The printer.cfg of such a printer, with what its firmware believes: z_tilt with the
/// screws as drawn, a mesh between them.
std::string PrinterCfgOfTripleZ(const Machine& machine, const std::string& serial);

}  // namespace caltwin
