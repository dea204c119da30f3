#include "sim/firmware/motion.h"

#include <algorithm>
#include <cmath>

#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

constexpr std::size_t kQueueLength = 40;  // As many as a Duet holds, about.

MotionLimits LimitsOf(const Machine& machine) {
  MotionLimits limits;
  for (const Axis axis : kAxes) {
    limits.feed_mm_s[Index(axis)] = machine.axis(axis).max_feed_mm_s;
    limits.acceleration_mm_s2[Index(axis)] = machine.axis(axis).acceleration_mm_s2;
  }
  return limits;
}

std::int64_t WholeSteps(double steps) {
  return std::llround(steps);
}

}  // namespace

Motion::Motion(const Machine& machine, const Settings* settings, Plant* plant)
    : settings_(settings),
      plant_(plant),
      drawings_(machine.axes),
      drives_(machine.kind->drive_map()),
      limits_(LimitsOf(machine)),
      motors_{{.drive = 0}, {.drive = 1}},
      queue_(limits_) {
  for (int i = 0; i < machine.kind->num_z_motors(); ++i)
    motors_.push_back({.drive = 2});
  NoteDone();
}

Motors Motion::MotorsNow() const {
  Motors steps(static_cast<Eigen::Index>(motors_.size()));
  for (Eigen::Index k = 0; k < steps.size(); ++k) {
    const Motor& motor = motors_[k];
    steps[k] = static_cast<double>(states_[motor.drive].motor() + motor.beside_steps);
  }
  return steps;
}

void Motion::NoteBeside(const Motors& whole_steps) {
  for (Eigen::Index k = 0; k < whole_steps.size(); ++k) {
    Motor& motor = motors_[k];
    const std::int64_t drive = states_[motor.drive].motor();
    if (WholeSteps(whole_steps[k]) == drive + motor.beside_steps) continue;
    motor.beside_steps = WholeSteps(whole_steps[k]) - drive;
    motor.rest_steps = 0;
  }
}

Vec3<double> Motion::AxesAt_mm(const Vec3<double>& counts) const {
  Vec3<double> drives_mm;
  for (int i = 0; i < 3; ++i) drives_mm[i] = counts[i] / settings_->steps_per_mm[i];
  return AxesOf(drives_, drives_mm);
}

Vec3<double> Motion::counts_now() const {
  Vec3<double> counts;
  for (int i = 0; i < 3; ++i) counts[i] = static_cast<double>(states_[i].count);
  return counts;
}

Vec3<double> Motion::counted_mm() const {
  return AxesAt_mm(counts_done_);
}

std::int64_t Motion::CountAt(int drive, const Vec3<double>& axes_mm) const {
  return WholeSteps(DrivesOf(drives_, axes_mm)[drive] * settings_->steps_per_mm[drive]);
}

bool Motion::Moves(int drive, Axis axis) const {
  if (drives_ == nullptr) return drive == Index(axis);
  return drives_->drives_by_axis(drive, Index(axis)) != 0;
}

Motion::StepPlan Motion::PlanSteps(const Vec3<double>& target_mm) {
  StepPlan plan;
  plan.segment.from_steps = MotorsNow();
  for (int i = 0; i < 3; ++i) {
    DriveState& state = states_[i];
    const double steps_per_mm = settings_->steps_per_mm[i];
    plan.by_steps[i] = CountAt(i, target_mm) - state.count;
    plan.delta_mm[i] = static_cast<double>(plan.by_steps[i]) / steps_per_mm;
    if (plan.by_steps[i] != 0) {
      const auto gap = WholeSteps(settings_->backlash_mm[i] * steps_per_mm);
      plan.backlash[i] = state.backlash.Take(plan.by_steps[i], gap, backlash_factor_);
      plan.is_empty = false;
    }
    state.count += plan.by_steps[i];
  }
  plan.segment.to_steps = MotorsNow();
  commanded_mm_ = target_mm;
  plan.delta_mm = AxesOf(drives_, plan.delta_mm);
  return plan;
}

void Motion::MoveTo(const Vec3<double>& target_mm, double feed_mm_s) {
  if (alarm_) return;
  const StepPlan plan = PlanSteps(target_mm);
  if (plan.is_empty) return;
  PlannedMove move = MakeMove(plan.delta_mm, feed_mm_s, limits_);
  move.segment.from_steps = plan.segment.from_steps;
  move.segment.to_steps = plan.segment.to_steps;
  queue_.Add(std::move(move));
  counts_queued_.push_back(counts_now());
  if (queue_.size() > kQueueLength) PerformFirst();
}

void Motion::PerformFirst() {
  const Segment segment = queue_.TakeFirst();
  const Outcome outcome = plant_->Run(segment, Watch{});
  time_s_ += outcome.time_s;
  if (outcome.alarm) {
    RaiseAlarm(*outcome.alarm, segment, outcome.time_s);
    return;
  }
  if (outcome.stopped) {  // By nobody but a hand: nothing was watched for.
    StandAt(segment, outcome.time_s);
    return;
  }
  motors_done_ = segment.to_steps;
  counts_done_ = counts_queued_.front();
  counts_queued_.pop_front();
}

void Motion::SetLimits(const MotionLimits& limits) {
  Finish();
  limits_ = limits;
  queue_ = MoveQueue(limits);
}

void Motion::PerformOne() {
  if (!alarm_ && !queue_.empty()) PerformFirst();
}

void Motion::Finish() {
  while (!alarm_ && !queue_.empty()) PerformFirst();
}

void Motion::Dwell(double s) {
  Finish();
  if (alarm_ || s <= 0) return;
  plant_->Dwell(s);
  time_s_ += s;
}

Motion::Ended Motion::RunAlone(const Vec3<double>& target_mm,
                               double feed_mm_s,
                               const Watch& watch) {
  const StepPlan plan = PlanSteps(target_mm);
  if (plan.is_empty) return {};
  MoveQueue alone(limits_);
  PlannedMove move = MakeMove(plan.delta_mm, feed_mm_s, limits_);
  move.segment.from_steps = plan.segment.from_steps;
  move.segment.to_steps = plan.segment.to_steps;
  alone.Add(std::move(move));
  const Segment segment = alone.TakeFirst();
  const Outcome outcome = plant_->Run(segment, watch);
  time_s_ += outcome.time_s;
  if (outcome.alarm) {
    RaiseAlarm(*outcome.alarm, segment, outcome.time_s);
  } else {
    if (outcome.stopped) AccountForStop(plan, segment, outcome);
    NoteDone();
  }
  return {.outcome = outcome, .feed_mm_s = segment.profile.Feed_mm_s(outcome.time_s)};
}

void Motion::AccountForStop(const StepPlan& plan,
                            const Segment& done,
                            const Outcome& outcome) {
  const Motors exact = outcome.stand_steps.value_or(done.Steps(outcome.time_s));
  const double share =
      done.profile.Distance_mm(outcome.time_s) / done.profile.length_mm;
  const Motors whole = exact.array().round();
  for (int i = 0; i < 3; ++i) {
    DriveState& state = states_[i];
    const auto applied = WholeSteps(share * static_cast<double>(plan.backlash[i]));
    state.backlash.Stopped(plan.backlash[i], applied);
    state.count = WholeSteps(whole[i]) - motors_[i].beside_steps - state.zero -
                  state.backlash.applied_steps();
  }
  NoteBeside(whole);
  const Vec3<double> stopped_mm = AxesAt_mm(counts_now());
  for (const Axis axis : kAxes) {
    for (int i = 0; i < 3; ++i) {
      if (plan.by_steps[i] == 0 || !Moves(i, axis)) continue;
      commanded_mm_[Index(axis)] = stopped_mm[Index(axis)];
    }
  }
  plant_->Settle(whole);
}

void Motion::StandAt(const Segment& segment, double time_s) {
  const Motors whole = segment.Steps(time_s).array().round();
  plant_->Settle(whole);
  motors_done_ = whole;
  DropQueue();
}

void Motion::RaiseAlarm(const std::string& words,
                        const Segment& segment,
                        double time_s) {
  StandAt(segment, time_s);
  is_homed_.fill(false);
  alarm_ = words;
}

void Motion::Abandon() {
  DropQueue();
  is_homed_.fill(false);
}

void Motion::DropQueue() {
  queue_.Clear();
  counts_queued_.clear();
  for (int i = 0; i < 3; ++i) {
    DriveState& state = states_[i];
    state.backlash.Clear();
    state.count = WholeSteps(motors_done_[i]) - motors_[i].beside_steps - state.zero;
  }
  NoteBeside(Motors(motors_done_));
  commanded_mm_ = AxesAt_mm(counts_now());
  NoteDone();
}

void Motion::NoteDone() {
  counts_done_ = counts_now();
  motors_done_ = MotorsNow();
}

void Motion::ForgetRests() {
  for (Motor& motor : motors_) motor.rest_steps = 0;
}

Vec3<double> Motion::beside_mm() const {
  Vec3<double> beside_mm = Vec3<double>::Zero();
  for (std::size_t i = 0; i < 3 && i < num_z_motors(); ++i) {
    beside_mm[static_cast<Eigen::Index>(i)] =
        static_cast<double>(motors_[2 + i].beside_steps) / settings_->steps_per_mm[2];
  }
  return beside_mm;
}

Vec3<double> Motion::z_zero_steps() const {
  Vec3<double> steps = Vec3<double>::Constant(static_cast<double>(states_[2].zero));
  for (std::size_t i = 0; i < 3 && i < num_z_motors(); ++i) {
    steps[static_cast<Eigen::Index>(i)] +=
        static_cast<double>(motors_[2 + i].beside_steps);
  }
  return steps;
}

void Motion::FollowFirst() {
  const std::int64_t first = motors_[2].beside_steps;
  for (std::size_t i = 2; i < motors_.size(); ++i) motors_[i].beside_steps -= first;
  states_[2].zero += first;
}

void Motion::MoveSingly(const Motors& by_mm, double feed_mm_s) {
  Finish();
  if (alarm_) return;
  Segment segment{.from_steps = MotorsNow()};
  double farthest_mm = 0;
  for (int i = 0; i < by_mm.size(); ++i) {
    Motor& motor = motors_[2 + i];
    const double to_steps = static_cast<double>(motor.beside_steps) + motor.rest_steps +
                            by_mm[i] * settings_->steps_per_mm[2];
    motor.beside_steps = WholeSteps(to_steps);
    motor.rest_steps = to_steps - static_cast<double>(motor.beside_steps);
    farthest_mm = std::max(farthest_mm, std::abs(by_mm[i]));
  }
  if (farthest_mm == 0) return;
  segment.to_steps = MotorsNow();
  MoveQueue alone(limits_);
  PlannedMove move = MakeMove(farthest_mm * Unit(Axis::kZ), feed_mm_s, limits_);
  move.segment.from_steps = segment.from_steps;
  move.segment.to_steps = segment.to_steps;
  alone.Add(std::move(move));
  segment = alone.TakeFirst();
  const Outcome outcome = plant_->Run(segment, Watch{});
  time_s_ += outcome.time_s;
  if (outcome.alarm) {
    RaiseAlarm(*outcome.alarm, segment, outcome.time_s);
  } else {
    NoteDone();
  }
}

void Motion::SetPosition(Axis axis, double mm) {
  Finish();
  commanded_mm_[Index(axis)] = mm;
  for (int i = 0; i < 3; ++i) {
    if (!Moves(i, axis)) continue;
    DriveState& state = states_[i];
    const std::int64_t motor = state.motor();
    state.backlash.Clear();
    state.count = CountAt(i, commanded_mm_);
    state.zero = motor - state.count;
  }
  is_homed_[Index(axis)] = true;
  NoteDone();
}

void Motion::KeepPosition() {
  Finish();
  for (int i = 0; i < 3; ++i) {
    DriveState& state = states_[i];
    const std::int64_t before = state.count;
    state.count = CountAt(i, commanded_mm_);
    state.zero += before - state.count;
  }
  NoteDone();
}

void Motion::KeepCounts() {
  Finish();
  commanded_mm_ = AxesAt_mm(counts_now());
  NoteDone();
}

void Motion::Recompute(bool ignores_backlash) {
  Finish();
  for (DriveState& state : states_) {
    if (!ignores_backlash) continue;
    state.count += state.backlash.applied_steps();
    state.backlash.Forget();
  }
  commanded_mm_ = AxesAt_mm(counts_now());
  NoteDone();
}

void Motion::PowerUpAt(const Motors& steps) {
  motors_done_ = steps;
  Restart();
}

void Motion::Restart() {
  queue_.Clear();
  counts_queued_.clear();
  alarm_.reset();
  for (int i = 0; i < 3; ++i) {
    states_[i] =
        DriveState{.zero = WholeSteps(motors_done_[i]) - motors_[i].beside_steps};
  }
  commanded_mm_.setZero();
  is_homed_.fill(false);
  ForgetRests();
  backlash_factor_ = 10;
  NoteDone();
}

Vec3<double> Motion::commanded_mm() const {
  return commanded_mm_;
}

Vec3<double> Motion::senses() const {
  Vec3<double> senses;
  for (int i = 0; i < 3; ++i) senses[i] = states_[i].backlash.sense();
  return senses;
}

}  // namespace caltwin
