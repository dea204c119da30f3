#include "sim/twin/fast_plant.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace caltwin {
namespace {

constexpr double kReached_mm = 1e-10;
constexpr double kLeastAdvance_mm = 1e-10;
constexpr double kNeverMet_mm = 1e9;
constexpr int kMostAdvances = 100'000;

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
  lag_mm_ = built_.LagAt_mm(lag_mm_, steps_, steps);
  steps_ = steps;
}

void FastPlant::Settle(const Motors& steps) {
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
  return BeforeSwitch_mm(watch, Carriage_mm(axis, steps_, lag_mm_)) <= 0;
}

FastPlant::Ahead FastPlant::Look(const Watch& watch,
                                 const Segment& segment,
                                 const Vec3<double>& steps,
                                 double allowed_mm) const {
  const Vec3<double> lag_mm = built_.LagAt_mm(lag_mm_, segment.from_steps, steps);
  const SurfaceDistance clearance = built_.Clearance(built_.Tip_mm(steps, lag_mm));
  Ahead ahead{.watched_mm = kNeverMet_mm,
              .collision_mm = clearance.distance_mm + allowed_mm};
  const double trigger_mm =
      clearance.distance_mm + built_.Pretravel_mm(clearance.normal) + scatter_mm_;
  if (watch.kind == Watch::Kind::kProbeTriggered) ahead.watched_mm = trigger_mm;
  if (watch.kind == Watch::Kind::kProbeReleased) {
    ahead.watched_mm = built_.machine.probe.hysteresis_mm - trigger_mm;
  }
  if (WatchesSwitch(watch)) {
    ahead.watched_mm = BeforeSwitch_mm(watch, Carriage_mm(watch.axis, steps, lag_mm));
  }
  return ahead;
}

Outcome FastPlant::Run(const Segment& segment, const Watch& watch) {
  Begin(segment);
  const double duration_s = segment.profile.Duration_s();
  const double axes_mm = Travel_mm(segment).norm();
  const double scale = axes_mm > 0 ? segment.profile.length_mm / axes_mm : 1;
  const double allowed_mm =
      AllowedDeflection_mm(-built_.Clearance(Tip_mm()).distance_mm);
  if (WatchesProbe(watch)) scatter_mm_ = DrawScatter_mm();

  Outcome outcome{.time_s = duration_s};
  double gone_mm = 0;
  for (int i = 0; i < kMostAdvances && gone_mm < segment.profile.length_mm; ++i) {
    const double t_s = segment.profile.Time_s(gone_mm);
    const Ahead ahead = Look(watch, segment, segment.Steps(t_s), allowed_mm);
    const double free_mm = std::min(ahead.watched_mm, ahead.collision_mm);
    if (free_mm <= kReached_mm) {
      outcome.stopped = true;
      outcome.time_s = t_s;
      if (ahead.collision_mm <= kReached_mm) outcome.alarm = CollisionText();
      break;
    }
    gone_mm += std::max(kLeastAdvance_mm, Caution() * free_mm) * scale;
  }
  if (outcome.stopped && !outcome.alarm && WatchesProbe(watch)) {
    outcome.time_s = std::min(duration_s, outcome.time_s + built_.probe.latency_s);
    triggered_ = watch.kind == Watch::Kind::kProbeTriggered;
    triggers_.push_back({segment.Steps(outcome.time_s), !triggered_});
  }
  GoTo(segment.Steps(outcome.time_s));
  End(outcome, watch);
  return outcome;
}

}  // namespace caltwin
