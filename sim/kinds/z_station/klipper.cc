#include "sim/kinds/z_station/klipper.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "sim/controllers/klipper/printer_cfg.h"
#include "sim/machine/kinds/z_station/drawing.h"

namespace caltwin {
namespace {

using klipper::CfgNumber;

constexpr std::array kNames = {"X", "Y", "Z"};
constexpr std::array kSections = {"stepper_x", "stepper_y", "stepper_z"};

ZStation WithoutChance(ZStation station) {
  station.endstop_scatter_mm = station.probe_scatter_mm = station.worn_mm = 0;
  return station;
}

/// Where the motor's steps are 0.
double Origin_mm(const Machine& machine, Axis axis) {
  return axis == Axis::kZ ? 0 : machine.axis(axis).home_mm();
}

std::string AxisCfg(const Machine& machine, Axis axis) {
  const auto at = static_cast<std::size_t>(Index(axis));
  const AxisDrawing& drawn = machine.axis(axis);
  const bool is_z = axis == Axis::kZ;
  return klipper::StepperCfg(
      {.section = kSections[at],
       .pin = kNames[at],
       .full_steps_per_rev = drawn.full_steps_per_rev,
       .microsteps = drawn.microsteps,
       .mm_per_rev = drawn.lead_mm,
       .rail = {{.min_mm = drawn.min_mm,
                 .max_mm = drawn.max_mm,
                 .endstop_mm = is_z ? ZStationOf(machine).switch_mm : drawn.home_mm(),
                 .homing_mm_s = std::min(is_z ? 8.0 : 50.0, drawn.max_feed_mm_s)}}});
}

}  // namespace

SteppedStation::SteppedStation(const Machine& machine,
                               const ZStation& station,
                               bool is_physics,
                               std::uint64_t seed)
    : machine_(machine),
      station_(station),
      quiet_(WithoutChance(station),
             is_physics,
             seed,
             /*sample=*/0,
             ZStationOf(machine).bed_at_mm),
      rng_(seed, /*sample=*/0, "z_station") {}

bool SteppedStation::IsDownAt(ZTouch touch,
                              const Eigen::Vector2d& at_mm,
                              double carriage_mm,
                              double late_mm) {
  const auto touched_mm = quiet_.Touch(touch, at_mm);
  return touched_mm && carriage_mm <= *touched_mm + late_mm;
}

bool SteppedStation::Acts(const PinSensor& sensor, const Motors& steps) {
  Vec3<double> at_mm;
  for (const Axis axis : kAxes) {
    at_mm[Index(axis)] = Origin_mm(machine_, axis) +
                         steps[Index(axis)] / machine_.axis(axis).steps_per_mm();
  }
  const Eigen::Vector2d head_mm = at_mm.head<2>();
  const Eigen::Vector2d knob_mm = head_mm + Eigen::Vector2d(kProbeOff_mm.data());
  if (sensor.kind == PinSensor::Kind::kProbe) {
    return IsDownAt(ZTouch::kProbeOnBed, knob_mm, at_mm[2], probe_late_mm_);
  }
  if (sensor.motor < 2) {
    const AxisDrawing& axis = machine_.axes[static_cast<std::size_t>(sensor.motor)];
    const double off_mm = at_mm[sensor.motor] - axis.home_mm();
    return (axis.home == HomeEnd::kMin ? off_mm : -off_mm) <= 0;
  }
  const Eigen::Vector2d switch_mm = ZStationOf(machine_).switch_at_mm;
  if ((head_mm - switch_mm).norm() < kSwitchReach_mm) {
    return IsDownAt(ZTouch::kNozzleOnSwitch, switch_mm, at_mm[2], endstop_late_mm_);
  }
  return (knob_mm - switch_mm).norm() < kSwitchReach_mm &&
         IsDownAt(ZTouch::kBodyOnSwitch, switch_mm, at_mm[2], endstop_late_mm_);
}

void SteppedStation::Arm(const PinSensor& sensor) {
  if (sensor.kind == PinSensor::Kind::kProbe) {
    probe_late_mm_ = station_.probe_scatter_mm * rng_.Normal();
  } else if (sensor.motor == 2) {
    endstop_late_mm_ = station_.endstop_scatter_mm * rng_.Normal() -
                       station_.worn_mm * rng_.Uniform() * rng_.Uniform();
  }
}

Wiring WiringOfStation(const Machine& machine) {
  constexpr double kUp_mm = 20;
  Wiring wiring;
  for (const Axis axis : kAxes) {
    const AxisDrawing& drawn = machine.axis(axis);
    const double stands_mm = axis == Axis::kZ ? kUp_mm : drawn.mid_mm();
    const double start_steps =
        (stands_mm - Origin_mm(machine, axis)) * drawn.steps_per_mm();
    const int motor = Index(axis);
    const std::string name = kNames[static_cast<std::size_t>(motor)];
    wiring.motors.push_back({.name = name, .start_steps = std::round(start_steps)});
    wiring.inputs.push_back(
        {name + "_STOP", {.kind = PinSensor::Kind::kSwitch, .motor = motor}});
  }
  wiring.inputs.push_back({"PROBE", {.kind = PinSensor::Kind::kProbe}});
  return wiring;
}

std::string PrinterCfgOfStation(const Machine& machine, const std::string& serial) {
  const AxisDrawing& x = machine.axis(Axis::kX);
  const AxisDrawing& z = machine.axis(Axis::kZ);
  const ZStationDrawing& drawn = ZStationOf(machine);
  std::string text = klipper::BeginningOfCfg(machine.name, serial) +
                     klipper::PrinterCfg({.max_velocity_mm_s = x.max_feed_mm_s,
                                          .max_accel_mm_s2 = x.acceleration_mm_s2,
                                          .max_z_velocity_mm_s = z.max_feed_mm_s,
                                          .max_z_accel_mm_s2 = z.acceleration_mm_s2});
  for (const Axis axis : kAxes) text += AxisCfg(machine, axis);
  const auto& off_mm = SteppedStation::kProbeOff_mm;
  text += fmt::format(
      "\n[probe]\npin: PROBE\nx_offset: {}\ny_offset: {}\nz_offset: {}\n"
      "speed: 5\nsamples: 3\nsample_retract_dist: 2\n",
      CfgNumber(off_mm[0]),
      CfgNumber(off_mm[1]),
      CfgNumber(drawn.body_mm + drawn.trigger_mm));
  const std::string over_switch = fmt::format(
      "{}, {}", CfgNumber(drawn.switch_at_mm[0]), CfgNumber(drawn.switch_at_mm[1]));
  return text + fmt::format(
                    "\n[safe_z_home]\nhome_xy_position: {0}\nz_hop: 12\n"
                    "\n[z_calibration]\nnozzle_xy_position: {0}\n"
                    "switch_xy_position: {1}, {2}\nbed_xy_position: {3}, {4}\n"
                    "switch_offset: {5}\nsafe_z_height: 15\nspeed: 100\n",
                    over_switch,
                    CfgNumber(drawn.switch_at_mm[0] - off_mm[0]),
                    CfgNumber(drawn.switch_at_mm[1] - off_mm[1]),
                    CfgNumber(drawn.bed_at_mm[0]),
                    CfgNumber(drawn.bed_at_mm[1]),
                    CfgNumber(drawn.trigger_mm));
}

}  // namespace caltwin
