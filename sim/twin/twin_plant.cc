#include "sim/twin/twin_plant.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "sim/base/require.h"

namespace caltwin {
namespace {

constexpr double kSwitchHysteresis_mm = 0.05;
constexpr double kFurtherOut_mm = 0.01;
constexpr double kScatterShare = 0.95;  // Of the deflection at the release.

}  // namespace

TwinPlant::TwinPlant(Built built, std::uint64_t seed, std::uint64_t sample)
    : built_(std::move(built)), scatter_rng_(seed, sample, "trigger_scatter") {
  steps_ = PowerUpSteps(built_);
}

Vec3<double> PowerUpSteps(const Built& built) {
  Vec3<double> motors_mm;
  for (const Axis axis : kAxes) {
    motors_mm[Index(axis)] = built.machine.axis(axis).mid_mm();
  }
  motors_mm[2] = built.machine.axis(Axis::kZ).max_mm - 10;
  return built.StepsAt(DrivesOf(built.drives(), motors_mm)).array().round();
}

Vec3<double> TwinPlant::Travel_mm(const Segment& segment) const {
  return AxesOf(
      built_.drives(),
      (segment.to_steps - segment.from_steps).cwiseQuotient(built_.steps_per_mm));
}

double TwinPlant::Carriage_mm(Axis axis,
                              const Vec3<double>& steps,
                              const Vec3<double>& lag_mm) const {
  return AxesOf(built_.drives(), built_.Motors_mm(steps) + lag_mm)[Index(axis)];
}

void TwinPlant::Begin(const Segment& segment) {
  Require(segment.to_steps.size() == 3, "three motors move this machine");
  const Vec3<double> from_mm = built_.Drawn_mm(segment.from_steps);
  const Vec3<double> by_steps = segment.to_steps - segment.from_steps;
  Vec3<double> travel = by_steps;
  if (auto& drives = built_.now.drives) {
    const Vec3<double> axes_mm = Travel_mm(segment);
    for (int i = 0; i < 3; ++i) {
      if (!drives->map->is_coupled(i)) continue;
      if (by_steps[i] != 0) drives->dir[i] = std::copysign(1, by_steps[i]);
      // Steps are whole: where an axis stands, one of its drives may make one more.
      const bool stands = std::abs(axes_mm[i]) * built_.steps_per_mm[i] < 1;
      travel[i] = stands ? 0 : axes_mm[i];
    }
  }
  for (int i = 0; i < 3; ++i) {
    if (travel[i] == 0) continue;
    const double sense = std::copysign(1, travel[i]);
    if (sense == built_.now.dir[i]) continue;
    built_.now.dir[i] = sense;
    built_.turned_at_mm[i] = from_mm[i];
  }
}

void TwinPlant::End(const Outcome& outcome, const Watch& watch) {
  Pass(outcome.time_s);
  if (!outcome.stopped || watch.kind != Watch::Kind::kSwitchClosed) return;
  ++homings_;
  home_ = fmt::format("{}", homings_);
  built_.now.home = home_;
  built_.now.homed_at_s = built_.now.t_s;
}

double TwinPlant::BeforeSwitch_mm(const Watch& watch, double carriage_mm) const {
  const AxisDrawing& axis = built_.machine.axis(watch.axis);
  const double off_mm = axis.home == HomeEnd::kMin ? carriage_mm - axis.min_mm
                                                   : axis.max_mm - carriage_mm;
  return watch.kind == Watch::Kind::kSwitchOpened ? kSwitchHysteresis_mm - off_mm
                                                  : off_mm;
}

double TwinPlant::DrawScatter_mm() {
  const double sd_mm = built_.scatter_mm();
  if (sd_mm == 0) return 0;
  // A switch opens after contact and closes before the stylus is back at rest, however
  // badly it scatters.
  double least_mm = built_.probe.pretravel_mm[0][0];
  for (const auto& both : built_.probe.pretravel_mm) {
    least_mm = std::min({least_mm, both[0], both[1]});
  }
  const double most_mm =
      kScatterShare * (least_mm - built_.machine.probe.hysteresis_mm);
  return std::clamp(sd_mm * scatter_rng_.Normal(), -most_mm, most_mm);
}

double TwinPlant::AllowedDeflection_mm(double now_mm) const {
  return std::max(built_.machine.probe.overtravel_mm, now_mm + kFurtherOut_mm);
}

bool WatchesProbe(const Watch& watch) {
  return watch.kind == Watch::Kind::kProbeTriggered ||
         watch.kind == Watch::Kind::kProbeReleased;
}

bool WatchesSwitch(const Watch& watch) {
  return watch.kind == Watch::Kind::kSwitchClosed ||
         watch.kind == Watch::Kind::kSwitchOpened;
}

std::string TwinPlant::CollisionText() const {
  return fmt::format("collision: the stylus was bent beyond its overtravel of {} mm",
                     built_.machine.probe.overtravel_mm);
}

}  // namespace caltwin
