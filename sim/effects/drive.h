#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "sim/effects/effect.h"

namespace caltwin {

/// What a drive moves: an axis of a cartesian machine, or a tower's carriage.
struct Drive {
  int index = 0;
  bool is_tower = false;
};

/// "x" .. "z", "a" .. "c"; nullopt for anything else.
constexpr std::optional<Drive> DriveNamed(std::string_view name) {
  if (name.size() != 1) return std::nullopt;
  if (name[0] >= 'x' && name[0] <= 'z') return Drive{name[0] - 'x', false};
  if (name[0] >= 'a' && name[0] <= 'c') return Drive{name[0] - 'a', true};
  return std::nullopt;
}

/// Its word as a covariate: "x", or "motor_a".
inline std::string DriveCovariate(std::string_view name) {
  return (DriveNamed(name)->is_tower ? "motor_" : "") + std::string(name);
}

/// Where it stands by command [mm]; a tower's counts down from its endstop.
template <typename T>
T DriveAt_mm(const Asked<T>& asked) {
  const Drive drive = *DriveNamed(asked.axis);
  if (!drive.is_tower) return asked.q_mm[drive.index];
  return T(asked.at.delta == nullptr ? 0.0 : asked.at.delta->motors_mm[drive.index]);
}

/// What it moves further than commanded [mm], in its own sense.
template <typename T>
T& DriveError_mm(std::string_view axis, Errors<T>* errors) {
  const Drive drive = *DriveNamed(axis);
  return drive.is_tower ? errors->motor_mm[drive.index]
                        : errors->motion_mm[drive.index];
}

/// How a delta's nozzle follows its carriages: errors in `motor_mm` and the gaps, as
/// the motors last moved [mm].
template <typename T>
Vec3<T> MotionOfMotors_mm(const DeltaAt& delta, const Errors<T>& errors) {
  const Vec3<T> moved_mm =
      errors.motor_mm -
      delta.motor_dir.cast<T>().cwiseProduct(errors.motor_lost_motion_mm) / T(2);
  // A carriage that is lower is one whose endstop is.
  return -delta.by_knob.middleCols<3>(kEndstopKnob).cast<T>() * moved_mm;
}

}  // namespace caltwin
