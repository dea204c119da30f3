#include "sim/kinds/cartesian/klipper.h"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>

#include "sim/kinds/cartesian/corners.h"
#include "sim/machine/kinds/cartesian/drawing.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

using klipper::CfgNumber;

constexpr std::array kNames = {"X", "Y", "Z"};
constexpr std::array kSections = {"stepper_x", "stepper_y", "stepper_z"};

std::string AxisCfg(const Machine& machine, Axis axis) {
  const auto at = static_cast<std::size_t>(Index(axis));
  const AxisDrawing& drawn = machine.axis(axis);
  const bool is_z = axis == Axis::kZ;
  klipper::StepperText text = StepperOf(machine, axis, kSections[at], kNames[at]);
  text.rail = {.min_mm = is_z ? drawn.min_mm - 5 : drawn.min_mm,
               .max_mm = drawn.max_mm,
               .endstop_mm = drawn.home_mm(),
               .homing_mm_s = std::min(is_z ? 10.0 : 50.0, drawn.max_feed_mm_s)};
  return klipper::StepperCfg(text);
}

}  // namespace

klipper::StepperText StepperOf(const Machine& machine,
                               Axis axis,
                               std::string section,
                               std::string pin) {
  const AxisDrawing& drawn = machine.axis(axis);
  const auto at = static_cast<std::size_t>(Index(axis));
  return {.section = std::move(section),
          .pin = std::move(pin),
          .full_steps_per_rev = drawn.full_steps_per_rev,
          .microsteps = drawn.microsteps,
          .mm_per_rev = drawn.full_steps_per_rev * drawn.microsteps /
                        machine.settings.steps_per_mm[at]};
}

std::string PrinterCfgOfGantry(const Machine& machine, const std::string& serial) {
  const AxisDrawing& x = machine.axis(Axis::kX);
  const AxisDrawing& y = machine.axis(Axis::kY);
  const AxisDrawing& z = machine.axis(Axis::kZ);
  std::string text =
      klipper::BeginningOfCfg(machine.name, serial) +
      klipper::PrinterCfg(
          {.is_corexy = machine.kind->drive_map() != nullptr,
           .max_velocity_mm_s = std::min(x.max_feed_mm_s, y.max_feed_mm_s),
           .max_accel_mm_s2 = std::min(x.acceleration_mm_s2, y.acceleration_mm_s2),
           .max_z_velocity_mm_s = z.max_feed_mm_s,
           .max_z_accel_mm_s2 = z.acceleration_mm_s2});
  for (const Axis axis : kAxes) text += AxisCfg(machine, axis);
  if (machine.Own<BeamDrawing>() != nullptr) {
    text += klipper::StepperCfg(StepperOf(machine, Axis::kY, "stepper_y1", "Y1"));
  }
  if (machine.Own<CornersDrawing>() != nullptr) text += CornersCfg(machine);
  const auto at = [](const AxisDrawing& axis, double share) {
    return CfgNumber(axis.min_mm + share * axis.travel_mm());
  };
  // A ball is at its trigger when it is pushed in by its pre-travel.
  return text +
         fmt::format(
             "\n[probe]\npin: PROBE\nz_offset: {}\nspeed: {}\n"
             "\n[bed_mesh]\nspeed: {}\nhorizontal_move_z: 5\n"
             "mesh_min: {}, {}\nmesh_max: {}, {}\nprobe_count: 5, 5\n",
             CfgNumber(machine.settings.tip_radius_mm - machine.probe.pretravel_mm),
             CfgNumber(machine.probe.speeds_mm_s.front()),
             CfgNumber(std::min(x.max_feed_mm_s, y.max_feed_mm_s)),
             at(x, 0.1),
             at(y, 0.1),
             at(x, 0.9),
             at(y, 0.9));
}

}  // namespace caltwin
