#include "sim/twin/physics_plant.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace caltwin {
namespace {

constexpr double kTimestep_s = BuiltWorld::kTimestep_s;
constexpr int kStepsBeforeContact = 20;
constexpr int kStepsBetweenLooks = 10;
constexpr double kLeastBeforeContact_mm = 0.005;
// A stylus that hangs back under acceleration (1 um at 0.3 m/s^2) or swings by less
// than this is at rest long before the next contact.
constexpr double kSwinging_mm = 3e-3;
constexpr double kSwinging_mm_s = 0.5;
constexpr double kAtRest_mm_s = 1e-3;
constexpr double kFarthestSeen_mm = 1000;
constexpr int kSettleSteps = 5;
constexpr int kMostSettleSteps = 250;

}  // namespace

PhysicsPlant::PhysicsPlant(Built built, std::uint64_t seed, std::uint64_t sample)
    : TwinPlant(std::move(built), seed, sample), drawn_(ModelOf(built_.machine)) {
  Rebuild();
  world_->StandAt(built_, steps_, built_.lag_center_mm);
}

void PhysicsPlant::Rebuild() {
  world_ = std::make_unique<BuiltWorld>(drawn_, built_);
  world_->Feel(built_, steps_);
}

void PhysicsPlant::Change(const std::vector<Artefact>& artefacts, Stylus stylus) {
  const Vec3<double> nuts_mm = world_->Nuts_mm();
  const Vec3<double> carriages_mm = world_->Carriages_mm();
  built_.artefacts = artefacts;
  built_.stylus = stylus;
  built_.Prepare();
  Rebuild();
  const Vec3<double> still = Vec3<double>::Zero();
  world_->Place(nuts_mm, carriages_mm, still, still);
  triggered_ = false;
}

Vec3<double> PhysicsPlant::Lag_mm() const {
  return DrivesOf(built_.drives(), world_->Carriages_mm()) - world_->Nuts_mm();
}

Vec3<double> PhysicsPlant::Tip_mm() {
  return world_->Tip_mm();
}

// -1: the stylus is not bent.
double PhysicsPlant::TriggerSignal_mm() const {
  const auto beyond_mm = world_->BeyondTrigger_mm(built_);
  return beyond_mm ? *beyond_mm - scatter_mm_ : -1;
}

// What is watched for, negative before and 0 when it happens.
double PhysicsPlant::Signal_mm(const Watch& watch) const {
  if (watch.kind == Watch::Kind::kProbeTriggered) return TriggerSignal_mm();
  if (watch.kind == Watch::Kind::kProbeReleased) {
    return -TriggerSignal_mm() - built_.machine.probe.hysteresis_mm;
  }
  if (WatchesSwitch(watch)) {
    return -BeforeSwitch_mm(watch, world_->Carriages_mm()[Index(watch.axis)]);
  }
  return -1;
}

bool PhysicsPlant::ProbeTriggered() {
  const double signal_mm = TriggerSignal_mm();
  if (signal_mm >= 0) triggered_ = true;
  if (signal_mm < -built_.machine.probe.hysteresis_mm) triggered_ = false;
  return triggered_;
}

bool PhysicsPlant::SwitchClosed(Axis axis) {
  const Watch watch{.kind = Watch::Kind::kSwitchClosed, .axis = axis};
  return BeforeSwitch_mm(watch, world_->Carriages_mm()[Index(axis)]) <= 0;
}

// The play operator holds while friction can stop the carriage as fast as its motor is
// stopped; else it coasts, and nothing may be jumped.
bool PhysicsPlant::MayJump(const Segment& segment) const {
  if (!jumps_) return false;
  const Vec3<double> travel = Travel_mm(segment);
  const double length_mm = travel.norm();
  const bool is_any_loose =
      !built_.lost_motion_mm.isZero() || !world_->drawn_gap_mm().isZero();
  // A belt without play pulls the head along the rail that rubs less; the play operator
  // holds only where both rub alike.
  const bool rubs_alike = built_.machine.axis(Axis::kX).rail_friction_n ==
                          built_.machine.axis(Axis::kY).rail_friction_n;
  if (built_.drives() != nullptr && is_any_loose && !rubs_alike) return false;
  for (const Axis axis : kAxes) {
    const int i = Index(axis);
    const bool is_own_loose =
        built_.lost_motion_mm[i] != 0 || world_->drawn_gap_mm()[i] != 0;
    const bool is_loose = built_.drives() != nullptr ? is_any_loose : is_own_loose;
    if ((!is_loose && built_.drive_effects.empty()) || length_mm == 0) continue;
    const AxisDrawing& drawing = built_.machine.axis(axis);
    const double acceleration_m_s2 =
        segment.profile.acceleration_mm_s2 * std::abs(travel[i]) / length_mm * 1e-3;
    if (drawing.moving_mass_kg * acceleration_m_s2 > drawing.rail_friction_n)
      return false;
  }
  return true;
}

double PhysicsPlant::FreePath_mm(const Watch& watch) const {
  double free_mm = world_->Clearance_mm(kFarthestSeen_mm);
  if (WatchesSwitch(watch)) {
    free_mm = std::min(
        free_mm, BeforeSwitch_mm(watch, world_->Carriages_mm()[Index(watch.axis)]));
  }
  return free_mm;
}

void PhysicsPlant::PlaceAt(const Segment& segment, double t_s) {
  const Vec3<double> steps = segment.Steps(t_s);
  const Vec3<double> lag_mm = built_.LagAt_mm(Lag_mm(), steps_, steps);
  const Vec3<double> travel =
      (segment.to_steps - segment.from_steps).cwiseQuotient(built_.steps_per_mm);
  const double length_mm = std::max(segment.profile.length_mm, 1e-12);
  const Vec3<double> nuts_mm_s = travel / length_mm * segment.profile.Feed_mm_s(t_s);
  Vec3<double> carriages_mm_s = nuts_mm_s;
  const Vec3<double> play_mm = built_.LostMotion_mm(built_.Drawn_mm(steps));
  for (int i = 0; i < 3; ++i) {
    const double behind_mm = play_mm[i] / 2;
    const double off_mm = lag_mm[i] - built_.lag_center_mm[i];
    const bool is_pushed = nuts_mm_s[i] * off_mm <= 0 && std::abs(off_mm) >= behind_mm;
    if (!is_pushed) carriages_mm_s[i] = 0;
  }
  const Vec3<double> nuts_mm = built_.Motors_mm(steps);
  world_->Feel(built_, steps);
  world_->Place(nuts_mm,
                AxesOf(built_.drives(), nuts_mm + lag_mm),
                nuts_mm_s,
                AxesOf(built_.drives(), carriages_mm_s));
  steps_ = steps;
}

// Puts the machine as far ahead on its path as is free; the time then, or `t_s` where
// it must be stepped.
double PhysicsPlant::Jump(const Segment& segment, const Watch& watch, double t_s) {
  if (world_->Deflection_mm().norm() > kSwinging_mm ||
      world_->Deflection_mm_s().norm() > kSwinging_mm_s) {
    return t_s;
  }
  const double feed_mm_s = std::max(segment.profile.Feed_mm_s(t_s),
                                    std::min(segment.profile.feed_top_mm_s, 1.0));
  const double near_mm =
      std::max(kLeastBeforeContact_mm, kStepsBeforeContact * kTimestep_s * feed_mm_s);
  const double free_mm = FreePath_mm(watch) - near_mm;
  if (free_mm <= near_mm * 0.1) return t_s;
  const double axes_mm = Travel_mm(segment).norm();
  const double scale = axes_mm > 0 ? segment.profile.length_mm / axes_mm : 1;
  const double gone_mm = segment.profile.Distance_mm(t_s);
  const double duration_s = segment.profile.Duration_s();
  const double to_mm = gone_mm + Caution() * free_mm * scale;
  const double to_s =
      to_mm >= segment.profile.length_mm ? duration_s : segment.profile.Time_s(to_mm);
  if (to_s < t_s + kStepsBeforeContact * kTimestep_s / 4 && to_s < duration_s)
    return t_s;
  PlaceAt(segment, to_s);
  return to_s;
}

void PhysicsPlant::StepTo(const Vec3<double>& steps) {
  world_->Feel(built_, steps);
  world_->Step(built_.Motors_mm(steps));
  steps_ = steps;
  ++num_steps_;
}

Outcome PhysicsPlant::Stopped(const Segment& segment,
                              const Watch& watch,
                              double t_s,
                              double at_s) {
  Outcome outcome{.stopped = true, .time_s = at_s};
  if (WatchesProbe(watch)) {
    triggered_ = watch.kind == Watch::Kind::kProbeTriggered;
    outcome.time_s =
        std::min(segment.profile.Duration_s(), at_s + built_.probe.latency_s);
    while (t_s < outcome.time_s) {
      t_s += kTimestep_s;
      StepTo(segment.Steps(t_s));
    }
    triggers_.push_back({segment.Steps(outcome.time_s), !triggered_});
  }
  return outcome;
}

Outcome PhysicsPlant::Run(const Segment& segment, const Watch& watch) {
  Begin(segment);
  const Outcome outcome = Perform(segment, watch);
  End(outcome, watch);
  return outcome;
}

Outcome PhysicsPlant::Perform(const Segment& segment, const Watch& watch) {
  const double duration_s = segment.profile.Duration_s();
  const bool may_jump = MayJump(segment);
  const double allowed_mm = AllowedDeflection_mm(world_->Deflection_mm().norm());
  if (WatchesProbe(watch)) scatter_mm_ = DrawScatter_mm();
  if (Signal_mm(watch) >= 0) return Stopped(segment, watch, 0, 0);

  double t_s = 0;
  for (int since_look = 0; t_s < duration_s; ++since_look) {
    if (may_jump && since_look % kStepsBetweenLooks == 0) {
      const double jumped_s = Jump(segment, watch, t_s);
      if (jumped_s > t_s) {
        t_s = jumped_s;
        since_look = -1;
        continue;
      }
    }
    const double before_mm = Signal_mm(watch);
    StepTo(segment.Steps(t_s + kTimestep_s));
    const double after_mm = Signal_mm(watch);
    t_s += kTimestep_s;
    if (world_->Deflection_mm().norm() > allowed_mm) {
      return {.stopped = true,
              .time_s = std::min(t_s, duration_s),
              .alarm = CollisionText()};
    }
    if (after_mm >= 0 && watch.kind != Watch::Kind::kNothing) {
      const double part = before_mm <= -1 ? 1 : before_mm / (before_mm - after_mm);
      const double at_s = std::min(duration_s, t_s - kTimestep_s * (1 - part));
      return Stopped(segment, watch, t_s, at_s);
    }
  }
  return {.stopped = false, .time_s = duration_s};
}

void PhysicsPlant::Settle(const Motors& steps) {
  const Vec3<double> from = steps_;
  for (int i = 1; i <= kSettleSteps; ++i) {
    StepTo(from + (steps - from) * (static_cast<double>(i) / kSettleSteps));
  }
  for (int i = 0; i < kMostSettleSteps; ++i) {
    if (world_->Carriages_mm_s().norm() < kAtRest_mm_s &&
        world_->Deflection_mm_s().norm() < kSwinging_mm_s) {
      return;
    }
    StepTo(steps);
  }
}

// At rest nothing creeps (friction holds to 0.01 um/s), so waiting changes nothing.
void PhysicsPlant::Dwell(double s) {
  Pass(s);
}

}  // namespace caltwin
