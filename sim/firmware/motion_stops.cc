// Moves that are ended by what they meet: the probe, a switch.

#include "sim/firmware/motion.h"

namespace caltwin {

Motion::Probed Motion::Probe(const Vec3<double>& target_mm,
                             double feed_mm_s,
                             Watch::Kind kind,
                             AtTrigger then) {
  Finish();
  if (alarm_) return {};
  const Vec3<double> way_mm = target_mm - commanded_mm_;
  const Ended ended = RunAlone(target_mm, feed_mm_s, {.kind = kind});
  const Probed probed{.stopped = ended.outcome.stopped, .at_mm = counted_mm()};
  if (probed.stopped && then == AtTrigger::kBrakes) {
    Brake(way_mm.normalized(), ended.feed_mm_s);
  }
  return probed;
}

void Motion::Brake(const Vec3<double>& along, double feed_mm_s) {
  if (feed_mm_s <= 0) return;
  const double acceleration_mm_s2 =
      MakeMove(along, feed_mm_s, limits_).acceleration_mm_s2;
  const double way_mm = feed_mm_s * feed_mm_s / (2 * acceleration_mm_s2);
  const StepPlan plan = PlanSteps(commanded_mm_ + way_mm * along);
  if (!plan.is_empty) {
    Segment segment = plan.segment;
    const double length_mm = plan.delta_mm.norm();  // In whole steps.
    segment.profile = {.length_mm = length_mm,
                       .feed_in_mm_s = feed_mm_s,
                       .feed_top_mm_s = feed_mm_s,
                       .feed_out_mm_s = 0,
                       .acceleration_mm_s2 = feed_mm_s * feed_mm_s / (2 * length_mm)};
    const Outcome outcome = plant_->Run(segment, Watch{});
    time_s_ += outcome.time_s;
    if (outcome.alarm) return RaiseAlarm(*outcome.alarm, segment, outcome.time_s);
    if (outcome.stopped) return StandAt(segment, outcome.time_s);
  }
  commanded_mm_ = AxesAt_mm(counts_now());
  NoteDone();
}

bool Motion::RunWhole(const Vec3<double>& target_mm, double feed_mm_s) {
  const Outcome outcome = RunAlone(target_mm, feed_mm_s, Watch{}).outcome;
  return !outcome.alarm && !outcome.stopped;
}

bool Motion::RunToSwitch(Axis axis, double travel_mm, double feed_mm_s) {
  if (plant_->SwitchClosed(axis)) return true;
  Vec3<double> target_mm = commanded_mm();
  target_mm[Index(axis)] += travel_mm;
  return RunAlone(target_mm, feed_mm_s, {Watch::Kind::kSwitchClosed, axis})
      .outcome.stopped;
}

bool Motion::Home(Axis axis, const Homing& homing) {
  Finish();
  if (alarm_) return false;
  const AxisDrawing& drawing = drawings_[Index(axis)];
  const double to_home = drawing.home == HomeEnd::kMin ? -1 : 1;
  const double search_mm = 1.1 * drawing.travel_mm() + 2 * homing.back_off_mm;
  is_homed_[Index(axis)] = false;
  if (axis == Axis::kZ) ForgetRests();
  if (!RunToSwitch(axis, to_home * search_mm, homing.fast_mm_s)) return false;
  Vec3<double> away_mm = commanded_mm();
  away_mm[Index(axis)] -= to_home * homing.back_off_mm;
  if (!RunWhole(away_mm, homing.fast_mm_s)) return false;
  if (!RunToSwitch(axis, to_home * 2 * homing.back_off_mm, homing.slow_mm_s)) {
    return false;
  }
  SetPosition(axis, drawing.home_mm());
  if (homing.pull_off_mm == 0) return true;
  away_mm = commanded_mm();
  away_mm[Index(axis)] -= to_home * homing.pull_off_mm;
  return RunWhole(away_mm, homing.fast_mm_s);
}

}  // namespace caltwin
