#include "sim/kinds/motor_stage/mechanism.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace caltwin {
namespace {

double Sign(double value) {
  return value > 0 ? 1.0 : value < 0 ? -1.0 : 0.0;
}

}  // namespace

double MagneticCycle(const MotorAxisDrawing& drawing) {
  return 4 * drawing.lead_unit / drawing.full_steps_per_rev;
}

double HoldingForce(const MotorAxisDrawing& drawing, double field_unit_s) {
  const double part = std::abs(field_unit_s) / (2 * drawing.max_velocity_unit_s);
  return drawing.largest_force() * std::max(0.05, 1 - part);
}

void FastMotors::Place(std::size_t axis, double motor_unit) {
  axes_[axis] = {};
  axes_[axis].state = {.motor_unit = motor_unit, .carriage_unit = motor_unit};
  axes_[axis].field_unit = motor_unit;
}

// Constant force for a tick, friction against the motion.
void FastMotors::Coast(const BuiltMotor& motor, double force, AxisNow* now) const {
  const MotorAxisDrawing& d = motor.drawing;
  MotorState& state = now->state;
  const double per_unit = d.total_inertia() * d.si_per_unit() / kTick_s;
  const double free_unit_s = state.motor_unit_s + force / per_unit;
  const double rubbed_unit_s = d.friction / per_unit;
  const double unit_s =
      Sign(free_unit_s) * std::max(0.0, std::abs(free_unit_s) - rubbed_unit_s);
  state.motor_unit += (state.motor_unit_s + unit_s) / 2 * kTick_s;
  state.motor_unit_s = unit_s;
  state.force = force;
}

void FastMotors::StopAtEnds(const BuiltMotor& motor, AxisNow* now) const {
  MotorState& state = now->state;
  const double half_unit = 0.5 * motor.gap_unit;
  const double low_unit = motor.lowest_unit() - half_unit;
  const double high_unit = motor.highest_unit() + half_unit;
  if (state.motor_unit < low_unit || state.motor_unit > high_unit) {
    state.motor_unit = std::clamp(state.motor_unit, low_unit, high_unit);
    state.motor_unit_s = 0;
  }
  state.carriage_unit = std::clamp(
      state.carriage_unit, state.motor_unit - half_unit, state.motor_unit + half_unit);
}

void FastMotors::Servo(const BuiltMotor& motor,
                       const MotorDrive& drive,
                       AxisNow* now) const {
  const MotorAxisDrawing& d = motor.drawing;
  MotorState& state = now->state;
  const double most = d.largest_force();
  const double inertia = d.total_inertia() * d.si_per_unit() / kTick_s;
  now->field_unit = drive.to_unit;
  if (drive.mode == MotorDrive::Mode::kOff) {
    Coast(motor, 0, now);
    return;
  }
  if (drive.mode == MotorDrive::Mode::kBrake) {
    const double force =
        -inertia * state.motor_unit_s + d.friction * Sign(state.motor_unit_s);
    Coast(motor, std::clamp(force, -most, most), now);
    return;
  }
  const double unit_s = (drive.to_unit - state.motor_unit) / kTick_s;
  const double needed =
      inertia * (unit_s - state.motor_unit_s) + d.friction * Sign(unit_s);
  if (std::abs(needed) > most) {
    Coast(motor, std::clamp(needed, -most, most), now);
    return;
  }
  state = {.motor_unit = drive.to_unit,
           .motor_unit_s = unit_s,
           .carriage_unit = state.carriage_unit,
           .force = needed};
}

// A rotor that its field has left behind: nothing drives it in the mean, until the
// field is slow enough to be caught at the nearest of its cycles.
void FastMotors::Slip(const BuiltMotor& motor, AxisNow* now) const {
  const MotorAxisDrawing& d = motor.drawing;
  Coast(motor, 0, now);
  const double cycle_unit = MagneticCycle(d);
  const double si = d.si_per_unit();
  // Where the energy of the difference no longer lifts it out of the well.
  const double deep =
      HoldingForce(d, now->field_unit_s) * cycle_unit * si / std::numbers::pi;
  const double slow_unit_s = std::sqrt(2 * deep / d.total_inertia()) / si;
  if (std::abs(now->state.motor_unit_s - now->field_unit_s) > slow_unit_s) return;
  const double behind_unit = now->state.motor_unit - now->field_unit;
  now->lost_unit = cycle_unit * std::round(behind_unit / cycle_unit);
  now->has_slipped = false;
}

void FastMotors::Stepper(const BuiltMotor& motor,
                         const MotorDrive& drive,
                         AxisNow* now) const {
  const MotorAxisDrawing& d = motor.drawing;
  if (drive.mode == MotorDrive::Mode::kOff) {
    Coast(motor, 0, now);
    now->lost_unit = now->state.motor_unit - now->field_unit;
    return;
  }
  const double to_unit =
      drive.mode == MotorDrive::Mode::kBrake ? now->field_unit : drive.to_unit;
  const double unit_s = (to_unit - now->field_unit) / kTick_s;
  const double needed =
      d.total_inertia() * d.si_per_unit() * (unit_s - now->field_unit_s) / kTick_s +
      d.friction * Sign(unit_s);
  now->field_unit = to_unit;
  now->field_unit_s = unit_s;
  const double most = HoldingForce(d, unit_s);
  if (std::abs(needed) >= most) now->has_slipped = true;
  if (now->has_slipped) {
    Slip(motor, now);
    return;
  }
  const double cycle_unit = MagneticCycle(d);
  const double lag_unit =
      std::asin(needed / most) * cycle_unit / (2 * std::numbers::pi);
  const double half_unit = motor.gap_unit / 2;
  double target_unit = to_unit + now->lost_unit - lag_unit;
  // Held at an end, the field goes on without it, a cycle at a time.
  while (target_unit > motor.highest_unit() + half_unit + cycle_unit / 2) {
    now->lost_unit -= cycle_unit;
    target_unit -= cycle_unit;
  }
  while (target_unit < motor.lowest_unit() - half_unit - cycle_unit / 2) {
    now->lost_unit += cycle_unit;
    target_unit += cycle_unit;
  }
  now->state = {.motor_unit = target_unit,
                .motor_unit_s = unit_s,
                .carriage_unit = now->state.carriage_unit,
                .force = needed};
}

// Told to stay where it stands: nothing of it changes.
bool FastMotors::IsResting(const AxisNow& now, const MotorDrive& drive) {
  return drive.mode == MotorDrive::Mode::kFollow &&
         drive.to_unit == now.state.motor_unit && drive.to_unit == now.field_unit &&
         now.state.motor_unit_s == 0 && now.field_unit_s == 0 && now.state.force == 0;
}

void FastMotors::Tick(const MotorDrives& drives) {
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    const BuiltMotor& motor = motors_[i];
    if (IsResting(axes_[i], drives[i])) continue;
    if (motor.drawing.is_servo) {
      Servo(motor, drives[i], &axes_[i]);
    } else {
      Stepper(motor, drives[i], &axes_[i]);
    }
    StopAtEnds(motor, &axes_[i]);
  }
}

}  // namespace caltwin
