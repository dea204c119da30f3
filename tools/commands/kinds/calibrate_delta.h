#pragma once

#include "scenarios/machine_file.h"
#include "tools/commands/calibrate.h"

namespace caltwin {

/// Calibrates a twin or the machine at the wire over Marlin's dialect. What a calliper
/// reads is asked as `calliper.rod.a1` .. (by tower and rod) and `calliper.print.1` ..
/// (the twelve distances, as Klipper's print has them: centre to each pillar, then from
/// pillar to pillar).
int CalibrateDeltaAtHand(const CalibrateOptions& options, const MachineFile& file);

}  // namespace caltwin
