#pragma once

#include <string>

#include "sim/measure/import/import.h"

namespace caltwin {

/// Reads config.g or config-override.g of RepRapFirmware as a machine file; of a
/// command given twice the last counts, as in the firmware. With M665 a delta:
///
/// - `M665 L<arm>[:<arm>:<arm>] R<delta radius> H<height> B<printable radius> X Y Z`:
///   X Y Z turn the towers counter-clockwise [deg] from 210, 330, 90;
/// - `M666 X Y Z`: endstop_i = H + its adjustment; `A B`, a tilt of the bed in percent,
///   is told: no machine file holds it;
/// - `M92 X Y Z` steps per mm, `M350 X Y Z` microsteps.
///
/// Without, three straight axes:
///
/// - `M92`, `M350` as above; `M425 X Y Z` backlash compensation [mm];
/// - `M208 X Y Z` most and, with S1, least of the axes, or both as `X-5:300` [mm];
/// - `M671 X Y` where three screws carry the bed; `M669 K1` and `M667 S1`: CoreXY.
///
/// No rows: a configuration measures nothing.
Imported ReadRrfConfig(const std::string& text,
                       const std::string& name,
                       const ImportOptions& options);

}  // namespace caltwin
