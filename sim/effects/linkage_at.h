#pragma once

#include "sim/machine/axis.h"
#include "sim/machine/kinds/delta/knobs.h"

namespace caltwin {

/// What a reading has beside its pose where links lead from motors to tip, as a delta's
/// rods: what its motors did, and how the nozzle moves with whatever may be wrong,
/// about the machine as it is believed to be built.
struct LinkageAt {
  Vec3<double> motors_mm =
      Vec3<double>::Zero();  ///< Commanded, down from the endstops.
  Vec3<double> motor_dir = Vec3<double>::Zero();  ///< Sense of each in the approach.
  Vec3<double> off_mm = Vec3<double>::Zero();     ///< Nozzle less commanded, by it.
  /// Of the nozzle by the knobs of the machine itself, inside values.
  Eigen::Matrix<double, 3, kNumDeltaKnobs> by_knob =
      Eigen::Matrix<double, 3, kNumDeltaKnobs>::Zero();
};

}  // namespace caltwin
