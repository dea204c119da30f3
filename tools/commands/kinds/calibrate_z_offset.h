#pragma once

#include "tools/commands/calibrate.h"

namespace caltwin {

/// Whether the first procedure asked for is one of a nozzle's height.
bool IsZStation(const CalibrateOptions& options);

/// `caltwin calibrate` of a nozzle's height: the twin z_station, or a printer with
/// Klipper's z_calibration on a wire (its own port: serial:/tmp/printer). Homes first.
/// Without --apply the offset that was in force before is put back.
int CalibrateZStationAtHand(const CalibrateOptions& options);

}  // namespace caltwin
