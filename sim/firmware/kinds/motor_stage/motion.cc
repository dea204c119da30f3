#include "sim/firmware/kinds/motor_stage/motion.h"

#include <algorithm>
#include <cmath>

namespace caltwin {
namespace {

constexpr double kWindow_pulses = 2;  // Of the position-complete signal,
constexpr double kSettled_s = 0.005;  // held for so long.
constexpr double kAtLimit = 0.98;     // Of the current limit counts as all of it.

}  // namespace

TrapezoidPath::TrapezoidPath(double length, double speed, double acceleration)
    : length_(length), speed_(speed), acceleration_(acceleration) {
  speed_ = std::min(speed, std::sqrt(length * acceleration));
  ramp_s_ = speed_ / acceleration;
  duration_s_ = speed_ > 0 ? length / speed_ + ramp_s_ : 0;
}

double TrapezoidPath::At(double t_s) const {
  if (stop_at_s_ && t_s > *stop_at_s_) {
    const double slow_s = std::min(t_s, stopped_s_) - *stop_at_s_;
    return stop_from_ + stop_speed_ * slow_s - stop_deceleration_ * slow_s * slow_s / 2;
  }
  if (t_s <= 0) return 0;
  if (t_s >= duration_s_) return length_;
  if (t_s < ramp_s_) return acceleration_ * t_s * t_s / 2;
  const double left_s = duration_s_ - t_s;
  if (left_s < ramp_s_) return length_ - acceleration_ * left_s * left_s / 2;
  return speed_ * (t_s - ramp_s_ / 2);
}

void TrapezoidPath::StopFrom(double t_s, double deceleration) {
  if (stop_at_s_) return;
  stop_from_ = At(t_s);
  stop_speed_ =
      std::clamp(std::min(t_s, duration_s_ - t_s) * acceleration_, 0.0, speed_);
  stop_at_s_ = t_s;
  stop_deceleration_ = deceleration;
  stopped_s_ = t_s + stop_speed_ / deceleration;
}

MotorMotion::MotorMotion(const Options& options, MotorRig* rig)
    : options_(options), rig_(rig), tick_s_(rig->tick_s()) {
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    count_before_[i] = rig->Count(i);
    axes_[i].target_pulses = static_cast<double>(rig->Count(i));
    axes_[i].last_drive_pulses = axes_[i].target_pulses;
  }
}

bool MotorMotion::KnownPressed(std::size_t axis, SwitchEnd end) const {
  return known_[axis][static_cast<std::size_t>(end)];
}

// The pins are read at once and known when the bus has carried the answer.
void MotorMotion::Poll() {
  if (has_news_ && time_s_ >= known_at_s_) {
    known_ = sampled_;
    has_news_ = false;
  }
  if (time_s_ < next_poll_s_) return;
  next_poll_s_ += options_.poll_s;
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    sampled_[i] = {rig_->IsPressed(i, SwitchEnd::kMin),
                   rig_->IsPressed(i, SwitchEnd::kMax)};
  }
  known_at_s_ = time_s_ + options_.transfer_s;
  has_news_ = true;
}

void MotorMotion::Watch(std::size_t i, const RigDrive& drive) {
  AxisState& axis = axes_[i];
  const double current_a = rig_->CurrentOf(i);
  axis.peak_a = std::max(axis.peak_a, current_a);
  const bool is_full =
      options_.is_servo[i] && current_a >= kAtLimit * options_.limit_a[i];
  axis.at_limit_s = is_full ? axis.at_limit_s + tick_s_ : 0;
  const double off_pulses = static_cast<double>(rig_->Count(i)) - drive.to_pulses;
  const bool is_there = std::abs(off_pulses) <= kWindow_pulses &&
                        drive.to_pulses == axis.last_drive_pulses;
  axis.in_position_s = is_there ? axis.in_position_s + tick_s_ : 0;
  axis.told_pulses_s = (drive.to_pulses - axis.last_drive_pulses) / tick_s_;
  axis.last_drive_pulses = drive.to_pulses;
  for (const std::int64_t count : rig_->TakeIndexEdges(i)) {
    if (!axis.index_enabled) continue;
    ++axis.index_edges;
    axis.last_index = count;
  }
}

void MotorMotion::Tick(const RigDrives& drives) {
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) count_before_[i] = rig_->Count(i);
  rig_->Tick(drives);
  time_s_ += tick_s_;
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) Watch(i, drives[i]);
  Poll();
}

RigDrives MotorMotion::Holding() const {
  RigDrives drives{};
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    drives[i].mode =
        axes_[i].is_enabled ? RigDrive::Mode::kFollow : RigDrive::Mode::kOff;
    drives[i].to_pulses = axes_[i].target_pulses;
  }
  return drives;
}

RigDrives MotorMotion::DrivesOf(const MotorMove& move, const Under& under) {
  RigDrives drives = Holding();
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    if (!move.moves[i]) continue;
    const double part = under.path.At(under.t_s - axes_[i].delay_s) / under.length;
    axes_[i].target_pulses = under.from[i] + under.way[i] * part;
    drives[i].to_pulses = axes_[i].target_pulses;
  }
  return drives;
}

bool MotorMotion::IsFound(const MotorMove& move, const Under& under) const {
  if (move.until == MotorMove::Until::kSwitch) {
    return KnownPressed(move.watched, move.end);
  }
  return move.until == MotorMove::Until::kIndex &&
         axes_[move.watched].index_edges > under.edges_before[move.watched];
}

// When the counter passes half of the way, between two ticks in proportion.
void MotorMotion::NoteHalfWay() {
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    AxisState& axis = axes_[i];
    if (axis.half_way_s || last_.way[i] == 0) continue;
    const double half = last_.way[i] / 2;
    const auto gone = static_cast<double>(rig_->Count(i) - last_.from_count[i]);
    if (gone / half < 1) continue;
    const auto before = static_cast<double>(count_before_[i] - last_.from_count[i]);
    const double part = gone == before ? 1 : (half - before) / (gone - before);
    axis.half_way_s = last_.t_s - tick_s_ * (1 - part);
  }
}

std::optional<std::size_t> MotorMotion::Blocked() const {
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    if (axes_[i].at_limit_s >= options_.blocked_s) return i;
  }
  return std::nullopt;
}

void MotorMotion::HoldHere() {
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    if (!options_.is_servo[i]) continue;
    axes_[i].target_pulses = static_cast<double>(rig_->Count(i));
    axes_[i].at_limit_s = 0;
  }
}

MotorArrival MotorMotion::Perform(const MotorMove& move) {
  last_ = {.path = TrapezoidPath(
               move.length_unit, move.speed_unit_s, move.acceleration_unit_s2),
           .length = std::max(move.length_unit, 1e-12)};
  Under& under = last_;
  double latest_s = 0;
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    under.from[i] = axes_[i].target_pulses;
    under.from_count[i] = rig_->Count(i);
    under.edges_before[i] = axes_[i].index_edges;
    axes_[i].half_way_s.reset();
    axes_[i].in_position_at_s.reset();
    if (!move.moves[i]) continue;
    under.way[i] = move.to_pulses[i] - under.from[i];
    latest_s = std::max(latest_s, axes_[i].delay_s);
  }
  MotorArrival arrival;
  while (under.t_s < under.path.duration_s() + latest_s) {
    under.t_s += tick_s_;
    Tick(DrivesOf(move, under));
    NoteHalfWay();
    if (!arrival.found && IsFound(move, under)) {
      arrival.found = true;
      under.path.StopFrom(under.t_s, move.acceleration_unit_s2);
    }
    arrival.blocked = Blocked();
    if (arrival.blocked) {
      HoldHere();
      return arrival;
    }
    if (relay_s_ && under.t_s >= *relay_s_) {
      // The input's interrupt has a time stamp; brakes act at ticks.
      const double since_s = under.t_s - *relay_s_;
      relay_s_.reset();
      EmergencyStop(since_s);
      arrival.stopped = true;
      return arrival;
    }
  }
  return arrival;
}

std::optional<std::size_t> MotorMotion::WaitInPosition(double patience_s) {
  std::optional<std::size_t> late;
  double waited_s = 0;
  while (waited_s <= patience_s) {
    late.reset();
    for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
      if (!options_.is_servo[i] || !axes_[i].is_enabled) continue;
      const bool is_there = axes_[i].in_position_s >= kSettled_s;
      if (!is_there) late = i;
      if (is_there && !axes_[i].in_position_at_s) axes_[i].in_position_at_s = waited_s;
    }
    if (!late) return std::nullopt;
    Tick(Holding());
    waited_s += tick_s_;
    // A drive that follows late passes its half way after the path has ended.
    last_.t_s += tick_s_;
    NoteHalfWay();
  }
  return late;
}

void MotorMotion::Wait(double seconds) {
  double waited_s = 0;
  while (waited_s < seconds) {
    Tick(Holding());
    waited_s += tick_s_;
  }
}

void MotorMotion::Enable(std::size_t axis, bool on) {
  if (on && !axes_[axis].is_enabled && options_.is_servo[axis]) {
    axes_[axis].target_pulses = static_cast<double>(rig_->Count(axis));
  }
  axes_[axis].is_enabled = on;
}

}  // namespace caltwin
