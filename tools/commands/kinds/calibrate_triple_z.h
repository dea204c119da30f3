#pragma once

#include "scenarios/machine_file.h"
#include "tools/commands/calibrate.h"

namespace caltwin {

/// Levels a twin or the printer at the wire over RepRapFirmware's dialect. Without
/// --apply levelling procedures only touch the bed and say what they would raise;
/// pivots are found (each screw raised and put back) and not written.
int CalibrateTripleZAtHand(const CalibrateOptions& options, const MachineFile& file);

}  // namespace caltwin
