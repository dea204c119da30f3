#include "sim/kinds/cartesian/stepped.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/effects/catalog.h"
#include "sim/machine/drive_map.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

constexpr std::array kNames = {"X", "Y", "Z", "Y1"};
constexpr int kY = Index(Axis::kY), kY1 = 3;

}  // namespace

SteppedGantry::SteppedGantry(Built built, std::uint64_t seed)
    : built_(std::move(built)),
      scatter_(seed, /*sample=*/0, "trigger_scatter"),
      steps_(Vec3<double>::Zero()),
      lag_mm_(built_.lag_center_mm),
      beam_(built_.machine.Own<BeamDrawing>()) {
  if (beam_ == nullptr) return;
  const int racking = *FindEffect("racking");
  auto& frame = built_.frame_effects;
  auto found = std::ranges::find(frame, racking, &Injected::effect);
  if (found == frame.end()) {
    frame.push_back({.effect = racking, .values = {0}});
    found = frame.end() - 1;
  }
  racking_ = static_cast<std::size_t>(found - frame.begin());
  apart_mm_ = beam_->apart_mm() * std::sin(RadFromMrad(found->values[0]));
  found->values[0] = turned_mrad_;  // Its motors stand alike.
}

Motors SteppedGantry::TurnedOn(const Vec3<double>& steps) const {
  if (beam_ == nullptr) return steps;
  Motors all(4);
  all << steps, steps[kY] + apart_mm_ * built_.steps_per_mm[kY];
  return all;
}

Vec3<double> SteppedGantry::Axes(const Motors& steps) {
  if (beam_ == nullptr) return steps;
  const double by_steps = steps[kY1] - steps[kY];
  const double sine = by_steps / built_.steps_per_mm[kY] / beam_->apart_mm();
  built_.frame_effects[racking_].values[0] =
      MradFromRad(std::asin(std::clamp(sine, -1.0, 1.0)));
  Vec3<double> axes = steps.head<3>();
  axes[kY] += beam_->Share(built_.machine.axis(Axis::kX).mid_mm()) * by_steps;
  return axes;
}

double SteppedGantry::BeforeHome_mm(Axis axis,
                                    const Vec3<double>& steps,
                                    const Vec3<double>& lag_mm) const {
  const Vec3<double> carriages_mm =
      AxesOf(built_.drives(), built_.Motors_mm(steps) + lag_mm);
  const AxisDrawing& drawn = built_.machine.axis(axis);
  const double off_mm = carriages_mm[Index(axis)] - drawn.home_mm();
  return drawn.home == HomeEnd::kMin ? off_mm : -off_mm;
}

// Both ends of a beam have come the way that its middle has, so lag alike.
bool SteppedGantry::SwitchActs(int motor, const Motors& steps) {
  const Vec3<double> lag_mm = LagAt_mm(Axes(steps));
  Vec3<double> ends = steps.head<3>();
  if (motor != kY1) {
    return BeforeHome_mm(kAxes[static_cast<std::size_t>(motor)], ends, lag_mm) <= 0;
  }
  ends[kY] = steps[kY1];
  const bool is_at_min = built_.machine.axis(Axis::kY).home == HomeEnd::kMin;
  return BeforeHome_mm(Axis::kY, ends, lag_mm) <= (is_at_min ? apart_mm_ : -apart_mm_);
}

bool SteppedGantry::Acts(const PinSensor& sensor, const Motors& steps) {
  const bool is_switch = sensor.kind == PinSensor::Kind::kSwitch;
  const bool acts = is_switch ? SwitchActs(sensor.motor, steps) : ProbeActs(steps);
  if (beam_ != nullptr) built_.frame_effects[racking_].values[0] = turned_mrad_;
  return acts;
}

bool SteppedGantry::ProbeActs(const Motors& steps) {
  const Vec3<double> to = Axes(steps);
  const SurfaceDistance clearance = built_.Clearance(built_.Tip_mm(to, LagAt_mm(to)));
  return clearance.distance_mm + built_.Pretravel_mm(clearance.normal) + late_mm_ <= 0;
}

void SteppedGantry::RequireUnjammed(const Motors& steps) const {
  constexpr double kMost_rad = 0.05;
  if (beam_ == nullptr) return;
  const double by_mm = (steps[kY1] - steps[kY]) / built_.steps_per_mm[kY];
  if (std::abs(by_mm) <= kMost_rad * beam_->apart_mm()) return;
  throw Jammed(fmt::format(
      "the beam is jammed: the motors of its ends are {:.1f} mm apart along Y", by_mm));
}

void SteppedGantry::Follow(const Motors& steps) {
  RequireUnjammed(steps);
  const Vec3<double> to = Axes(steps);
  if (beam_ != nullptr) turned_mrad_ = built_.frame_effects[racking_].values[0];
  const Vec3<double> by_mm = built_.Drawn_mm(to) - built_.Drawn_mm(steps_);
  for (int i = 0; i < 3; ++i) {
    const double sense = by_mm[i] > 0 ? 1 : -1;
    if (by_mm[i] == 0 || sense == built_.now.dir[i]) continue;
    built_.turned_at_mm[i] = built_.Drawn_mm(steps_)[i];
    built_.now.dir[i] = sense;
  }
  if (auto& drives = built_.now.drives) {
    for (int i = 0; i < 3; ++i) {
      const double by_steps = to[i] - steps_[i];
      if (drives->map->is_coupled(i) && by_steps != 0) {
        drives->dir[i] = std::copysign(1, by_steps);
      }
    }
  }
  lag_mm_ = LagAt_mm(to);
  steps_ = to;
}

void SteppedGantry::Arm(const PinSensor& sensor) {
  if (sensor.kind != PinSensor::Kind::kProbe) return;
  late_mm_ = built_.scatter_mm() * scatter_.Normal();
}

Wiring WiringOfGantry(const Machine& machine) {
  Vec3<double> axes_mm;
  for (const Axis axis : kAxes) {
    const AxisDrawing& drawn = machine.axis(axis);
    const double stands_mm =
        axis == Axis::kZ ? drawn.min_mm + 0.8 * drawn.travel_mm() : drawn.mid_mm();
    axes_mm[Index(axis)] = stands_mm - drawn.home_mm();
  }
  const Vec3<double> drives_mm = DrivesOf(machine.kind->drive_map(), axes_mm);
  Wiring wiring;
  const auto add = [&](int motor, int drive) {
    const auto at = static_cast<std::size_t>(drive);
    const std::string name = kNames[static_cast<std::size_t>(motor)];
    wiring.motors.push_back({.name = name,
                             .start_steps = std::round(
                                 drives_mm[drive] * machine.axes[at].steps_per_mm())});
    wiring.inputs.push_back(
        {name + "_STOP", {.kind = PinSensor::Kind::kSwitch, .motor = motor}});
  };
  for (int i = 0; i < 3; ++i) add(i, i);
  if (machine.Own<BeamDrawing>() != nullptr) add(kY1, kY);
  wiring.inputs.push_back({"PROBE", {.kind = PinSensor::Kind::kProbe}});
  return wiring;
}

}  // namespace caltwin
