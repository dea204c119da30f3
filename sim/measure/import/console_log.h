#pragma once

#include "sim/measure/import/import.h"

namespace caltwin {

/// Reads what a printer or mill and its host said to each other: the terminal of
/// OctoPrint, Pronterface, Mainsail, Fluidd or Duet Web Control, of any firmware.
///
///   Klipper         `probe at X,Y is z=Z`; since 2026 `probe: at X,Y bed will contact
///   at
///                   z=Z`, which is relative to the nominal bed
///   Marlin          `Bed X: Y: Z:` of G30 and G29 V4, M48, UBL's topography with the
///                   coordinates of its corners, `M503`
///   RepRapFirmware  `Stopped at height Z`, `bed probe heights: ...` behind `G30 Pn X
///   Y` grbl            `[PRB:x,y,z:1]` behind the `G38` that moved
///
/// Homing and levelling begin a new `home`, a tool another `setup`; reported
/// temperatures stand beside the touches that follow. A log whose times run backwards
/// is read from its end. `M92` ... are the settings in force, `M665` and `M666` a
/// delta's machine file.
Imported ReadConsoleLog(const std::string& text,
                        const std::string& name,
                        const ImportOptions& options);

}  // namespace caltwin
