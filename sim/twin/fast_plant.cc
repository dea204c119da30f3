#include "sim/twin/fast_plant.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace caltwin {
namespace {

constexpr double kReached_mm = 1e-10;
constexpr double kLeastAdvance_mm = 1e-10;
// Motion errors make the tip's path longer than the motors': up to 5 % for a screw.
constexpr double kCaution = 0.95;
constexpr int kMostAdvances = 100'000;

bool WatchesProbe(const Watch& watch) {
  return watch.kind == Watch::Kind::kProbeTriggered ||
         watch.kind == Watch::Kind::kProbeReleased;
}

}  // namespace

FastPlant::FastPlant(Built built, std::uint64_t seed, std::uint64_t sample)
    : TwinPlant(std::move(built), seed, sample), lag_mm_(built_.lag_center_mm) {}

void FastPlant::Change(const std::vector<Artefact>& artefacts, Stylus stylus) {
  built_.artefacts = artefacts;
  built_.stylus = stylus;
  built_.Prepare();
  triggered_ = false;
}

Vec3<double> FastPlant::Tip_mm() {
  return built_.Tip_mm(steps_, lag_mm_);
}

void FastPlant::GoTo(const Vec3<double>& steps) {
  lag_mm_ = LagAt_mm(lag_mm_, steps_, steps);
  steps_ = steps;
}

void FastPlant::Settle(const Vec3<double>& steps) {
  GoTo(steps);
}

bool FastPlant::ProbeTriggered() {
  const SurfaceDistance clearance = built_.Clearance(Tip_mm());
  const double beyond_mm =
      -clearance.distance_mm - built_.Pretravel_mm(clearance.normal) - scatter_mm_;
  if (beyond_mm >= 0) triggered_ = true;
  if (beyond_mm < -built_.machine.probe.hysteresis_mm) triggered_ = false;
  return triggered_;
}

bool FastPlant::SwitchClosed(Axis axis) {
  const Watch watch{.kind = Watch::Kind::kSwitchClosed, .axis = axis};
  return BeforeSwitch_mm(
             watch, built_.Motors_mm(steps_)[Index(axis)] + lag_mm_[Index(axis)]) <= 0;
}

double FastPlant::Ahead_mm(const Watch& watch,
                           const Segment& segment,
                           const Vec3<double>& steps) const {
  const Vec3<double> lag_mm = LagAt_mm(lag_mm_, segment.from_steps, steps);
  if (watch.kind == Watch::Kind::kSwitchClosed ||
      watch.kind == Watch::Kind::kSwitchOpened) {
    const int i = Index(watch.axis);
    return BeforeSwitch_mm(watch, built_.Motors_mm(steps)[i] + lag_mm[i]);
  }
  const SurfaceDistance clearance = built_.Clearance(built_.Tip_mm(steps, lag_mm));
  const double trigger_mm =
      clearance.distance_mm + built_.Pretravel_mm(clearance.normal) + scatter_mm_;
  if (watch.kind == Watch::Kind::kProbeTriggered) return trigger_mm;
  if (watch.kind == Watch::Kind::kProbeReleased) {
    return built_.machine.probe.hysteresis_mm - trigger_mm;
  }
  return clearance.distance_mm + built_.machine.probe.overtravel_mm;
}

Outcome FastPlant::Run(const Segment& segment, const Watch& watch) {
  const double duration_s = segment.profile.Duration_s();
  const double motors_mm =
      (segment.to_steps - segment.from_steps).cwiseQuotient(built_.steps_per_mm).norm();
  const double scale = motors_mm > 0 ? segment.profile.length_mm / motors_mm : 1;
  if (WatchesProbe(watch)) scatter_mm_ = DrawScatter_mm();

  Outcome outcome{.time_s = duration_s};
  double gone_mm = 0;
  for (int i = 0; i < kMostAdvances && gone_mm < segment.profile.length_mm; ++i) {
    const double t_s = TimeAt_s(segment.profile, gone_mm);
    const double ahead_mm = Ahead_mm(watch, segment, segment.Steps(t_s));
    if (ahead_mm <= kReached_mm) {
      outcome.stopped = true;
      outcome.time_s = t_s;
      break;
    }
    gone_mm += std::max(kLeastAdvance_mm, kCaution * ahead_mm) * scale;
  }
  if (outcome.stopped && watch.kind == Watch::Kind::kNothing) {
    outcome.alarm = CollisionText();
  }
  if (outcome.stopped && WatchesProbe(watch)) {
    outcome.time_s = std::min(duration_s, outcome.time_s + built_.probe.latency_s);
    triggered_ = watch.kind == Watch::Kind::kProbeTriggered;
    triggers_.push_back({segment.Steps(outcome.time_s), !triggered_});
  }
  lag_mm_ = LagAt_mm(lag_mm_, segment.from_steps, segment.Steps(outcome.time_s));
  steps_ = segment.Steps(outcome.time_s);
  return outcome;
}

}  // namespace caltwin
