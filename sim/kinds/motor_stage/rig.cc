#include "sim/kinds/motor_stage/rig.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/kinds/motor_stage/physics.h"

namespace caltwin {
namespace {

constexpr double kRest_pulses = 0.8;    // A servo rests within so much,
constexpr double kRest_pulses_s = 500;  // and creeps there that fast.

MotorDrive::Mode ModeOf(RigDrive::Mode mode) {
  if (mode == RigDrive::Mode::kFollow) return MotorDrive::Mode::kFollow;
  return mode == RigDrive::Mode::kBrake ? MotorDrive::Mode::kBrake
                                        : MotorDrive::Mode::kOff;
}

}  // namespace

MotorStageRig::MotorStageRig(const BuiltMotorStage& built,
                             bool is_physics,
                             std::uint64_t seed,
                             std::uint64_t sample)
    : built_(built),
      switch_scatter_(seed, sample, "switch_scatter"),
      rest_(seed, sample, "servo_rest") {
  if (is_physics) {
    mechanism_ = std::make_unique<PhysicsMotors>(built.drawing.model, built.motors);
  } else {
    mechanism_ = std::make_unique<FastMotors>(built.motors);
  }
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    const double tick_s = MotorMechanism::kTick_s;
    const double ticks = built.faults[i].start_delay_s / tick_s;
    axes_[i].delay_part = ticks - std::floor(ticks);
    // The place told so many ticks ago, and the one before it.
    const auto whole = static_cast<std::size_t>(ticks);
    axes_[i].delayed.assign(ticks > 0 ? whole + 1 : 0, 0);
    for (Switch& each : axes_[i].switches) {
      each.scatter_unit =
          built.faults[i].switch_scatter_unit * switch_scatter_.Normal();
    }
    mechanism_->Place(i, built.faults[i].start_unit);
    SenseAll(i, mechanism_->State(i));
  }
}

// Of the counter, less than 1 where the axis stood at power-up.
double MotorStageRig::PulsesAt(std::size_t axis, double motor_unit) const {
  const MotorFaults& faults = built_.faults[axis];
  const double gone_unit = motor_unit - faults.start_unit;
  return gone_unit * built_.motors[axis].drawing.pulses_per_unit() + faults.pulse_part;
}

void MotorStageRig::Rest(std::size_t i, double told) {
  AxisNow& axis = axes_[i];
  const bool moves = told != axis.last_told;
  if (axis.was_moving && !moves) {
    axis.rest_goal_pulses = kRest_pulses * (2 * rest_.Uniform() - 1);
  }
  axis.was_moving = moves;
  axis.last_told = told;
  const double most = kRest_pulses_s * MotorMechanism::kTick_s;
  axis.rest_pulses += std::clamp(axis.rest_goal_pulses - axis.rest_pulses, -most, most);
}

MotorDrive MotorStageRig::DriveOf(std::size_t i, const RigDrive& told) {
  AxisNow& axis = axes_[i];
  const MotorAxisDrawing& d = built_.motors[i].drawing;
  double pulses = told.to_pulses;
  if (!axis.delayed.empty()) {
    // Off or braking it is told nothing: from there on it begins where it stands.
    if (told.mode != RigDrive::Mode::kFollow) {
      pulses = static_cast<double>(axis.count);
      std::ranges::fill(axis.delayed, pulses);
    }
    // Between ticks in proportion.
    axis.delayed.push_back(pulses);
    pulses = (1 - axis.delay_part) * axis.delayed[1] +
             axis.delay_part * axis.delayed.front();
    axis.delayed.erase(axis.delayed.begin());
  }
  if (d.is_servo) Rest(i, pulses);
  // The drive follows its counter: pulses it lost, the motor goes on by.
  const double motor_pulses =
      pulses + axis.lost_pulses + (d.is_servo ? axis.rest_pulses : 0);
  return {ModeOf(told.mode),
          built_.faults[i].start_unit + motor_pulses / d.pulses_per_unit()};
}

void MotorStageRig::SenseIndex(std::size_t i, double before_unit, double now_unit) {
  const MotorAxisDrawing& d = built_.motors[i].drawing;
  const MotorFaults& faults = built_.faults[i];
  const double speed_unit_s =
      std::abs(now_unit - before_unit) / MotorMechanism::kTick_s;
  if (faults.index_lost_above_unit_s &&
      speed_unit_s > *faults.index_lost_above_unit_s) {
    return;
  }
  // The pulse is one count wide; its edge is the side that comes first.
  const bool is_plus = now_unit > before_unit;
  const double width_unit = is_plus ? 0 : 1 / d.pulses_per_unit();
  const double first_unit = d.min_switch_unit + d.index_from_switch_unit + width_unit;
  const double from_turns = (before_unit - first_unit) / d.lead_unit;
  const double to_turns = (now_unit - first_unit) / d.lead_unit;
  const double at_turn = is_plus ? std::floor(to_turns) : std::ceil(to_turns);
  const bool is_crossed = is_plus ? at_turn > from_turns && at_turn <= to_turns
                                  : at_turn < from_turns && at_turn >= to_turns;
  if (!is_crossed) return;
  const double edge_unit = first_unit + at_turn * d.lead_unit;
  const double pulses = PulsesAt(i, edge_unit) - axes_[i].lost_pulses;
  axes_[i].edges.push_back(static_cast<std::int64_t>(std::floor(pulses)));
}

void MotorStageRig::SenseSwitch(std::size_t i,
                                SwitchEnd end,
                                std::optional<double> before_unit,
                                double carriage_unit) {
  const MotorAxisDrawing& d = built_.motors[i].drawing;
  const MotorFaults& faults = built_.faults[i];
  const bool is_min = end == SwitchEnd::kMin;
  if (is_min ? faults.min_switch_missing : faults.max_switch_missing) return;
  Switch& each = axes_[i].switches[static_cast<std::size_t>(end)];
  const double place_unit = is_min ? d.min_switch_unit : d.max_switch_unit;
  // How far beyond the switch the carriage is.
  const double beyond_unit = is_min ? place_unit + each.scatter_unit - carriage_unit
                                    : carriage_unit - place_unit - each.scatter_unit;
  // While the carriage leaves it, it does not close at the place of the next approach:
  // only those would be left that lie behind the carriage.
  const bool is_approached = !before_unit || (is_min ? carriage_unit < *before_unit
                                                     : carriage_unit > *before_unit);
  if (!each.is_closed) {
    each.is_closed = beyond_unit >= 0 && is_approached;
    return;
  }
  if (beyond_unit >= -d.switch_hysteresis_unit) return;
  each.is_closed = false;
  each.scatter_unit = faults.switch_scatter_unit * switch_scatter_.Normal();
}

void MotorStageRig::SenseAll(std::size_t i, const MotorState& before) {
  AxisNow& axis = axes_[i];
  const MotorAxisDrawing& d = built_.motors[i].drawing;
  const MotorState now = mechanism_->State(i);
  const bool is_still = d.is_servo && now.motor_unit == before.motor_unit &&
                        now.carriage_unit == axis.sensed_unit;
  if (is_still) return;
  const std::optional<double> sensed_unit =
      std::exchange(axis.sensed_unit, now.carriage_unit);
  SenseSwitch(i, SwitchEnd::kMin, sensed_unit, now.carriage_unit);
  SenseSwitch(i, SwitchEnd::kMax, sensed_unit, now.carriage_unit);
  if (!d.is_servo) {
    axis.count = static_cast<std::int64_t>(std::llround(axis.last_told));
    return;
  }
  const MotorFaults& faults = built_.faults[i];
  const double gone_unit = now.motor_unit - before.motor_unit;
  if (std::abs(gone_unit) / MotorMechanism::kTick_s > faults.pulses_lost_above_unit_s) {
    axis.lost_pulses += faults.pulses_lost * gone_unit * d.pulses_per_unit();
  }
  SenseIndex(i, before.motor_unit, now.motor_unit);
  axis.count = static_cast<std::int64_t>(
      std::floor(PulsesAt(i, now.motor_unit) - axis.lost_pulses));
}

void MotorStageRig::Tick(const RigDrives& drives) {
  MotorDrives motor_drives{};
  std::array<MotorState, kNumMotorAxes> before{};
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    before[i] = mechanism_->State(i);
    motor_drives[i] = DriveOf(i, drives[i]);
    if (!built_.motors[i].drawing.is_servo) axes_[i].last_told = drives[i].to_pulses;
  }
  mechanism_->Tick(motor_drives);
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) SenseAll(i, before[i]);
}

double MotorStageRig::CurrentOf(std::size_t axis) const {
  return std::abs(mechanism_->State(axis).force) /
         built_.motors[axis].drawing.force_per_amp;
}

bool MotorStageRig::IsPressed(std::size_t axis, SwitchEnd end) const {
  return axes_[axis].switches[static_cast<std::size_t>(end)].is_closed;
}

std::vector<std::int64_t> MotorStageRig::TakeIndexEdges(std::size_t axis) {
  return std::exchange(axes_[axis].edges, {});
}

void MotorStageRig::MoveByHand(std::size_t axis, double to_unit) {
  const MotorState before = mechanism_->State(axis);
  mechanism_->Place(axis, to_unit);
  SenseAll(axis, before);
  axes_[axis].edges.clear();
}

}  // namespace caltwin
