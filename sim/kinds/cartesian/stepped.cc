#include "sim/kinds/cartesian/stepped.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/effects/catalog.h"
#include "sim/effects/predict.h"
#include "sim/effects/racking.h"
#include "sim/machine/drive_map.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

constexpr std::array kNames = {"X", "Y", "Z", "Y1"};
constexpr int kY = Index(Axis::kY), kY1 = 3;
constexpr double kJammed_mrad = 50;

}  // namespace

SteppedGantry::SteppedGantry(Built built, bool is_physics, std::uint64_t seed)
    : built_(std::move(built)),
      beam_(built_.machine.Own<BeamDrawing>()),
      scatter_(seed, /*sample=*/0, "trigger_scatter"),
      lag_mm_(built_.lag_center_mm) {
  if (beam_ != nullptr) {
    const auto is_racking = [](const Injected& effect) {
      return effect.effect == EffectIndex<Racking>();
    };
    for (const Injected& effect : built_.effects) {
      if (!is_racking(effect)) continue;
      apart_mm_ += beam_->apart_mm() * std::sin(RadFromMrad(effect.values[0]));
    }
    std::erase_if(built_.effects, is_racking);
    std::erase_if(built_.frame_effects, is_racking);
  }
  if (is_physics) {
    world_ = std::make_unique<BuiltWorld>(ModelOf(built_.machine), built_);
  }
}

Motors SteppedGantry::TurnedOn(const Vec3<double>& steps) const {
  if (beam_ == nullptr) return steps;
  Motors all(4);
  all << steps, steps[kY] + apart_mm_ * built_.steps_per_mm[kY];
  return all;
}

SteppedGantry::Stand SteppedGantry::StandAt(const Motors& motors) const {
  Stand stand{.steps = motors.head<3>()};
  if (beam_ == nullptr) return stand;
  const double by_steps = motors[kY1] - motors[kY];
  const double sine = by_steps / built_.steps_per_mm[kY] / beam_->apart_mm();
  stand.racking_mrad = MradFromRad(std::asin(std::clamp(sine, -1.0, 1.0)));
  stand.steps[kY] += beam_->Share(built_.machine.axis(Axis::kX).mid_mm()) * by_steps;
  return stand;
}

Vec3<double> SteppedGantry::MovedByRacking_mm(const Stand& stand,
                                              const Vec3<double>& lag_mm) const {
  if (stand.racking_mrad == 0) return Vec3<double>::Zero();
  At at =
      built_.AtAxes(AxesOf(built_.drives(), built_.Motors_mm(stand.steps) + lag_mm));
  at.steps_per_mm.setZero();
  at.compensation_mm.setZero();
  const std::vector<Injected> racking = {
      {.effect = EffectIndex<Racking>(), .values = {stand.racking_mrad}}};
  return ErrorsAt<double>(built_.machine, at, racking).motion_mm;
}

Vec3<double> SteppedGantry::TipAt_mm(const Stand& stand,
                                     const Vec3<double>& lag_mm) const {
  return built_.Tip_mm(stand.steps, lag_mm) + MovedByRacking_mm(stand, lag_mm);
}

Vec3<double> SteppedGantry::Tip_mm() const {
  if (world_ == nullptr) return TipAt_mm(stand_, lag_mm_);
  world_->StandAt(built_, stand_.steps, lag_mm_, MovedByRacking_mm(stand_, lag_mm_));
  return world_->Tip_mm();
}

// Both ends of a beam have come the way that its middle has, so lag alike.
bool SteppedGantry::SwitchActs(int motor, const Motors& motors) const {
  Vec3<double> ends = motors.head<3>();
  if (motor == kY1) ends[kY] = motors[kY1];
  const Axis axis = motor == kY1 ? Axis::kY : kAxes[static_cast<std::size_t>(motor)];
  const double at_mm = motor == kY1 ? apart_mm_ : 0;
  const Vec3<double> carriages_mm =
      AxesOf(built_.drives(), built_.Motors_mm(ends) + LagAt_mm(StandAt(motors)));
  const AxisDrawing& drawn = built_.machine.axis(axis);
  const double off_mm = carriages_mm[Index(axis)] - drawn.home_mm() - at_mm;
  return drawn.home == HomeEnd::kMin ? off_mm <= 0 : off_mm >= 0;
}

bool SteppedGantry::ProbeActs(const Stand& stand) const {
  // Beyond it nothing has to be looked at closely.
  constexpr double kClose_mm = 1;
  const Vec3<double> lag_mm = LagAt_mm(stand);
  const SurfaceDistance clearance = built_.Clearance(TipAt_mm(stand, lag_mm));
  if (world_ == nullptr || std::abs(clearance.distance_mm) > kClose_mm) {
    return clearance.distance_mm + built_.Pretravel_mm(clearance.normal) + late_mm_ <=
           0;
  }
  world_->StandAt(built_, stand.steps, lag_mm, MovedByRacking_mm(stand, lag_mm));
  const auto beyond_mm = world_->RestsBeyondTrigger_mm(built_, stand.steps);
  return beyond_mm && *beyond_mm >= late_mm_;
}

bool SteppedGantry::Acts(const PinSensor& sensor, const Motors& steps) {
  if (sensor.kind == PinSensor::Kind::kSwitch) return SwitchActs(sensor.motor, steps);
  return ProbeActs(StandAt(steps));
}

void SteppedGantry::Follow(const Motors& steps) {
  const Stand stand = StandAt(steps);
  if (std::abs(stand.racking_mrad) > kJammed_mrad) {
    throw Jammed(fmt::format(
        "the beam is jammed: the motors of its ends are {:.1f} mm apart along Y",
        (steps[kY1] - steps[kY]) / built_.steps_per_mm[kY]));
  }
  const Vec3<double> to = stand.steps, from = stand_.steps;
  const Vec3<double> by_mm = built_.Drawn_mm(to) - built_.Drawn_mm(from);
  for (int i = 0; i < 3; ++i) {
    const double sense = by_mm[i] > 0 ? 1 : -1;
    if (by_mm[i] == 0 || sense == built_.now.dir[i]) continue;
    built_.turned_at_mm[i] = built_.Drawn_mm(from)[i];
    built_.now.dir[i] = sense;
  }
  if (auto& drives = built_.now.drives) {
    for (int i = 0; i < 3; ++i) {
      const double by_steps = to[i] - from[i];
      if (drives->map->is_coupled(i) && by_steps != 0) {
        drives->dir[i] = std::copysign(1, by_steps);
      }
    }
  }
  lag_mm_ = LagAt_mm(stand);
  stand_ = stand;
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
