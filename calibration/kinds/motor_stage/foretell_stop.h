#pragma once

#include <map>
#include <optional>

#include "calibration/kinds/motor_stage/doing.h"

namespace caltwin {

/// The gap that the controller compensates (M425) [mm, deg], known to a pulse. Where
/// that is 0 nobody measured one.
struct KnownGap {
  double gap_unit = 0;
  double sd_unit = 0;
};
std::optional<KnownGap> GapOf(std::size_t axis, MotorDoing* doing);

/// Each axis' stop as it is foretold.
using StopForecasts = std::map<std::size_t, StopForecast>;

/// Foretells the stop of every axis of the options from that speed and says so. Warns
/// where it does not stand in time, where the forecast cannot be sure, and where a gap
/// that nobody measured, as large as the options' tolerance, would change the verdict.
std::optional<StopForecasts> ForetellStops(double speed_unit_s, MotorDoing* doing);

}  // namespace caltwin
