#include "sim/kinds/motor_stage/physics.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace caltwin {

PhysicsMotors::PhysicsMotors(const std::filesystem::path& model,
                             const BuiltMotors& motors)
    : MotorMechanism(motors),
      world_(CompileMotorStage(model, motors, kTick_s), motors) {}

void PhysicsMotors::Place(std::size_t axis, double motor_unit) {
  world_.Place(axis, motor_unit, motor_unit);
  force_[axis] = 0;
  field_unit_[axis] = motor_unit;
}

// The inertia that a servo's drive is tuned for. Inside a gap its motor is alone, and
// would swing up, tick by tick, where the drive is tuned for more than 4/3 of it, or
// brakes for more than twice: of either three quarters.
double PhysicsMotors::InertiaFor(std::size_t axis, bool brakes) const {
  const MotorAxisDrawing& d = motors_[axis].drawing;
  if (motors_[axis].gap_unit == 0) return d.total_inertia();
  const double most = 0.75 * (brakes ? 2 : 4.0 / 3);
  return std::min(d.total_inertia(), most * d.motor_inertia);
}

double PhysicsMotors::ServoForce(std::size_t axis, const MotorDrive& drive) {
  const MotorAxisDrawing& d = motors_[axis].drawing;
  const bool brakes = drive.mode == MotorDrive::Mode::kBrake;
  const bool begins = !std::exchange(brakes_[axis], brakes) && brakes;
  if (drive.mode == MotorDrive::Mode::kOff) return 0;
  const double unit_s = world_.MotorSpeed_unit_s(axis);
  const double off_unit = brakes ? 0 : drive.to_unit - world_.MotorAt(axis);
  const double force = InertiaFor(axis, brakes) * d.si_per_unit() *
                       (off_unit - unit_s * kTick_s) / (kTick_s * kTick_s);
  const double most = d.largest_force();
  const double now = std::clamp(force, -most, most);
  // MuJoCo's speeds are those between its positions: a brake acts from the middle of
  // such a step on.
  return begins ? (force_[axis] + now) / 2 : now;
}

double PhysicsMotors::StepperForce(std::size_t axis, const MotorDrive& drive) {
  constexpr double kDamping = 0.3;  // Of the rotor about its field, of critical.
  const MotorAxisDrawing& d = motors_[axis].drawing;
  if (drive.mode == MotorDrive::Mode::kOff) return 0;
  const double to_unit =
      drive.mode == MotorDrive::Mode::kBrake ? field_unit_[axis] : drive.to_unit;
  const double field_unit_s = (to_unit - field_unit_[axis]) / kTick_s;
  field_unit_[axis] = to_unit;
  const double si = d.si_per_unit();
  const double turn = 2 * std::numbers::pi / MagneticCycle(d);
  const double most = HoldingForce(d, field_unit_s);
  const double stiffness = most * turn / si;
  const double damping = 2 * kDamping * std::sqrt(stiffness * d.total_inertia());
  // The field of the tick's end acts on the rotor where it would be then.
  const double unit_s = world_.MotorSpeed_unit_s(axis);
  const double ahead_unit = world_.MotorAt(axis) + unit_s * kTick_s;
  const double force = -most * std::sin(turn * (ahead_unit - to_unit)) -
                       damping * si * (unit_s - field_unit_s);
  return std::clamp(force, -most, most);
}

void PhysicsMotors::Tick(const MotorDrives& drives) {
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    force_[i] = motors_[i].drawing.is_servo ? ServoForce(i, drives[i])
                                            : StepperForce(i, drives[i]);
    world_.SetForce(i, force_[i]);
  }
  world_.Step();
}

MotorState PhysicsMotors::State(std::size_t axis) const {
  return {.motor_unit = world_.MotorAt(axis),
          .motor_unit_s = world_.MotorSpeed_unit_s(axis),
          .carriage_unit = world_.CarriageAt(axis),
          .force = force_[axis]};
}

}  // namespace caltwin
