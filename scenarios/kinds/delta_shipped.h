#pragma once

#include <cstdint>
#include <string>

#include "calibration/kinds/delta/bench.h"
#include "sim/kinds/delta/plant.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {

/// What a host with that printer.cfg believes of a delta. Throws InputError.
DeltaModel<double> DeltaBelievedBy(const std::string& printer_cfg);

/// Klipper's own host, as shipped, calibrates a delta that is drawn as `delta_printer`
/// and built so: G28, DELTA_CALIBRATE with seven touches within `radius_mm`,
/// SAVE_CONFIG, in closed form and lock-step. `messages`: what it refused, or the
/// printer.cfg that it saved. Throws HostLost; InputError where it is not installed.
DeltaOutcome CalibrateByKalico(const BuiltDelta& built,
                               double radius_mm,
                               std::uint64_t seed);

}  // namespace caltwin
