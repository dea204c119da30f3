#pragma once

#include <string>

#include "sim/measure/import/import.h"

namespace caltwin {

/// Reads what a Marlin printer said on its terminal, as OctoPrint, Pronterface or a
/// capture of the port keep it (`Recv:`, `Send:`, `>>>`, `echo:` before a line are left
/// away; a date and time before it becomes t_s).
///
///  - `Bed X: 10.00 Y: 20.00 Z: 0.03` (G30, and G29 V3 or V4) and `2 of 10: z: 0.031`
///    (M48) become `touch` rows: value = reported z, the height of the bed where it was
///    touched, nozzle offset included as Marlin includes it. A G29 and an M48 are
///    campaigns of their own, all G30 together one; each G28 begins a homing session.
///  - `M92 X80.00 ...` (M503) becomes the settings in force; `M665` with `M666` a
///    machine file of the delta: endstop = H - M666.
///
/// Refuses a log whose only heights are a levelling grid, since the grid does not say
/// where its points lie, and touches of one place that run away (climb.h).
Imported ReadMarlinLog(const std::string& text,
                       const std::string& name,
                       const ImportOptions& options);

}  // namespace caltwin
