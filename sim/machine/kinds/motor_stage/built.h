#pragma once

#include <algorithm>
#include <array>
#include <optional>

#include "sim/machine/kinds/motor_stage/drawing.h"

namespace caltwin {

/// One motor's mechanics as built: its drawing with what is wrong with it, and its gap.
struct BuiltMotor {
  MotorAxisDrawing drawing{};
  double gap_unit = 0;  ///< Between motor and carriage: the whole width.
  /// Where something in the way stops the carriage on either side; nullopt: nothing.
  std::optional<double> low_obstacle_unit{}, high_obstacle_unit{};

  /// The ends of what the carriage can do: hard stops, or what is in the way.
  double lowest_unit() const {
    const double stop_unit = drawing.min_switch_unit - drawing.stop_unit;
    return std::max(low_obstacle_unit.value_or(stop_unit), stop_unit);
  }
  double highest_unit() const {
    const double stop_unit = drawing.max_switch_unit + drawing.stop_unit;
    return std::min(high_obstacle_unit.value_or(stop_unit), stop_unit);
  }
};
using BuiltMotors = std::array<BuiltMotor, kNumMotorAxes>;

}  // namespace caltwin
