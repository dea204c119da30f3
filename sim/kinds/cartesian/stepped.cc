#include "sim/kinds/cartesian/stepped.h"

#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "sim/machine/drive_map.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

constexpr std::array kNames = {"X", "Y", "Z"};

}  // namespace

SteppedGantry::SteppedGantry(Built built, std::uint64_t seed)
    : built_(std::move(built)),
      scatter_(seed, /*sample=*/0, "trigger_scatter"),
      steps_(Vec3<double>::Zero()),
      lag_mm_(built_.lag_center_mm) {}

double SteppedGantry::BeforeHome_mm(Axis axis, const Vec3<double>& steps) const {
  const Vec3<double> carriages_mm =
      AxesOf(built_.drives(), built_.Motors_mm(steps) + LagAt_mm(steps));
  const AxisDrawing& drawn = built_.machine.axis(axis);
  const double off_mm = carriages_mm[Index(axis)] - drawn.home_mm();
  return drawn.home == HomeEnd::kMin ? off_mm : -off_mm;
}

bool SteppedGantry::Acts(const PinSensor& sensor, const Motors& steps) {
  const Vec3<double> to = steps;
  if (sensor.kind == PinSensor::Kind::kSwitch) {
    return BeforeHome_mm(kAxes[static_cast<std::size_t>(sensor.motor)], to) <= 0;
  }
  const SurfaceDistance clearance = built_.Clearance(built_.Tip_mm(to, LagAt_mm(to)));
  return clearance.distance_mm + built_.Pretravel_mm(clearance.normal) + late_mm_ <= 0;
}

void SteppedGantry::Follow(const Motors& steps) {
  const Vec3<double> to = steps;
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
  for (int i = 0; i < 3; ++i) {
    const auto at = static_cast<std::size_t>(i);
    wiring.motors.push_back(
        {.name = kNames[at],
         .start_steps = std::round(drives_mm[i] * machine.axes[at].steps_per_mm())});
    wiring.inputs.push_back({std::string(kNames[at]) + "_STOP",
                             {.kind = PinSensor::Kind::kSwitch, .motor = i}});
  }
  wiring.inputs.push_back({"PROBE", {.kind = PinSensor::Kind::kProbe}});
  return wiring;
}

}  // namespace caltwin
