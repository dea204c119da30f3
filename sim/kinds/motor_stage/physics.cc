#include "sim/kinds/motor_stage/physics.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace caltwin {

PhysicsMotors::PhysicsMotors(const std::filesystem::path& model,
                             const BuiltMotors& motors)
    : MotorMechanism(motors), spec_(ReadMotorStageSpec(model)) {}

void PhysicsMotors::Place(std::size_t axis, double motor_unit) {
  AxisNow& now = axes_[axis];
  now.placed_unit = motor_unit;
  if (now.world) now.world->Place(axis, motor_unit, motor_unit);
  const bool is_free = motor_unit >= motors_[axis].lowest_unit() &&
                       motor_unit <= motors_[axis].highest_unit();
  now.is_at_rest = is_free;
  force_[axis] = 0;
  field_unit_[axis] = motor_unit;
}

MotorStageWorld* PhysicsMotors::WorldOf(std::size_t axis) {
  AxisNow& now = axes_[axis];
  if (!now.world) {
    now.world.emplace(CompileMotorAxis(spec_.get(), axis, motors_[axis], kTick_s),
                      motors_);
    now.world->Place(axis, now.placed_unit, now.placed_unit);
  }
  return &*now.world;
}

// What rests under a force rests on under it.
void PhysicsMotors::Step(std::size_t axis, double force) {
  AxisNow& now = axes_[axis];
  const double before = std::exchange(force_[axis], force);
  if (now.is_at_rest && force == before) return;
  MotorStageWorld* const world = WorldOf(axis);
  const double motor_unit = world->MotorAt(axis);
  const double carriage_unit = world->CarriageAt(axis);
  world->SetForce(axis, force);
  world->Step();
  now.is_at_rest =
      world->MotorAt(axis) == motor_unit && world->CarriageAt(axis) == carriage_unit &&
      world->MotorSpeed_unit_s(axis) == 0 && world->CarriageSpeed_unit_s(axis) == 0;
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
  const MotorState state = State(axis);
  const double unit_s = state.motor_unit_s;
  const double off_unit = brakes ? 0 : drive.to_unit - state.motor_unit;
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
  const MotorState state = State(axis);
  const double unit_s = state.motor_unit_s;
  const double ahead_unit = state.motor_unit + unit_s * kTick_s;
  const double force = -most * std::sin(turn * (ahead_unit - to_unit)) -
                       damping * si * (unit_s - field_unit_s);
  return std::clamp(force, -most, most);
}

void PhysicsMotors::Tick(const MotorDrives& drives) {
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    Step(i,
         motors_[i].drawing.is_servo ? ServoForce(i, drives[i])
                                     : StepperForce(i, drives[i]));
  }
}

MotorState PhysicsMotors::State(std::size_t axis) const {
  const AxisNow& now = axes_[axis];
  if (!now.world) {
    return {.motor_unit = now.placed_unit,
            .carriage_unit = now.placed_unit,
            .force = force_[axis]};
  }
  return {.motor_unit = now.world->MotorAt(axis),
          .motor_unit_s = now.world->MotorSpeed_unit_s(axis),
          .carriage_unit = now.world->CarriageAt(axis),
          .force = force_[axis]};
}

}  // namespace caltwin
