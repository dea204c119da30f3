#pragma once

#include <string>

#include "sim/measure/import/import.h"

namespace caltwin {

/// Reads config.g or config-override.g of a RepRapFirmware delta as a machine file; of
/// a command given twice the last counts, as in the firmware.
///
/// - `M665 L<arm>[:<arm>:<arm>] R<delta radius> H<height> B<printable radius> X Y Z`:
///   X Y Z turn the towers counter-clockwise [deg] from 210, 330, 90;
/// - `M666 X Y Z`: endstop_i = H + its adjustment; `A B`, a tilt of the bed in percent,
///   is told: no machine file holds it;
/// - `M92 X Y Z` steps per mm, `M350 X Y Z` microsteps.
///
/// No rows: a configuration measures nothing.
Imported ReadRrfConfig(const std::string& text,
                       const std::string& name,
                       const ImportOptions& options);

}  // namespace caltwin
