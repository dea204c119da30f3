#include "sim/kinds/triple_z/klipper.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "sim/controllers/klipper/printer_cfg.h"
#include "sim/machine/drive_map.h"
#include "sim/machine/kinds/triple_z/drawing.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

using klipper::CfgNumber;

constexpr std::array kNames = {"X", "Y", "Z", "Z1", "Z2"};
constexpr std::array kSections = {
    "stepper_x", "stepper_y", "stepper_z", "stepper_z1", "stepper_z2"};

/// Travel per turn that gives as many steps per mm as the firmware believes.
double BelievedLead_mm(const Machine& machine, Axis axis) {
  const AxisDrawing& drawn = machine.axis(axis);
  return drawn.full_steps_per_rev * drawn.microsteps /
         machine.settings.steps_per_mm[static_cast<std::size_t>(Index(axis))];
}

std::string HeadCfg(const Machine& machine, Axis axis) {
  const auto at = static_cast<std::size_t>(Index(axis));
  const AxisDrawing& drawn = machine.axis(axis);
  return klipper::StepperCfg({.section = kSections[at],
                              .pin = kNames[at],
                              .full_steps_per_rev = drawn.full_steps_per_rev,
                              .microsteps = drawn.microsteps,
                              .mm_per_rev = BelievedLead_mm(machine, axis),
                              .rail = {{.min_mm = drawn.min_mm,
                                        .max_mm = drawn.max_mm,
                                        .endstop_mm = drawn.home_mm()}}});
}

std::string ScrewCfg(const Machine& machine, int screw) {
  const auto at = static_cast<std::size_t>(screw);
  const ScrewDrawing& drawn = TripleZOf(machine).screws[at];
  klipper::StepperText text{.section = kSections[2 + at],
                            .pin = kNames[2 + at],
                            .full_steps_per_rev = drawn.full_steps_per_rev,
                            .microsteps = drawn.microsteps,
                            .mm_per_rev = drawn.lead_mm};
  // The first is Z's; the others follow it.
  const double top_mm = TripleZOf(machine).top_mm;
  if (screw == 0) {
    text.rail = {
        .min_mm = -5, .max_mm = top_mm, .endstop_mm = top_mm, .homing_mm_s = 10};
  }
  return klipper::StepperCfg(text);
}

std::string LevellingCfg(const Machine& machine) {
  const Pivots<double> pivots_mm = TripleZOf(machine).pivots_mm();
  Eigen::Vector2d least = pivots_mm[0], most = pivots_mm[0];
  std::string places, reached;
  const auto line_of = [](const Eigen::Vector2d& at) {
    return fmt::format("  {}, {}\n", CfgNumber(at[0]), CfgNumber(at[1]));
  };
  const Eigen::Vector2d low(machine.axes[0].min_mm, machine.axes[1].min_mm);
  const Eigen::Vector2d high(machine.axes[0].max_mm, machine.axes[1].max_mm);
  for (const Eigen::Vector2d& at : pivots_mm) {
    places += line_of(at);
    // A screw may stand where the nozzle does not come.
    reached += line_of(at.cwiseMax(low).cwiseMin(high));
    least = least.cwiseMin(at);
    most = most.cwiseMax(at);
  }
  least = least.cwiseMax(low);
  most = most.cwiseMin(high);
  return fmt::format(
      "\n[probe]\npin: PROBE\nz_offset: {6}\nspeed: 5\n"
      "\n[z_tilt]\nz_positions:\n{0}points:\n{5}speed: 150\nhorizontal_move_z: 8\n"
      "retries: 3\nretry_tolerance: 0.01\n"
      "\n[bed_mesh]\nspeed: 150\nhorizontal_move_z: 8\nmesh_min: {1}, {2}\n"
      "mesh_max: {3}, {4}\nprobe_count: 5, 5\n",
      places,
      CfgNumber(least[0]),
      CfgNumber(least[1]),
      CfgNumber(most[0]),
      CfgNumber(most[1]),
      reached,
      // At its trigger the nozzle is pushed in by so much.
      CfgNumber(-machine.probe.pretravel_mm));
}

}  // namespace

Wiring WiringOfTripleZ(const Machine& machine) {
  constexpr std::array kFromHome_mm = {61.0, 44.0};
  constexpr std::array kRaised_mm = {30.0, 30.8, 29.4};
  const auto& steps_per_mm = machine.settings.steps_per_mm;
  Vec3<double> axes_mm = Vec3<double>::Zero();
  for (int i = 0; i < 2; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const bool is_up = machine.axes[at].home == HomeEnd::kMin;
    axes_mm[i] = is_up ? kFromHome_mm[at] : -kFromHome_mm[at];
  }
  const Vec3<double> drives_mm = DrivesOf(machine.kind->drive_map(), axes_mm);
  Wiring wiring;
  for (int i = 0; i < 2 + kNumScrews; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const double start_steps =
        i < 2 ? drives_mm[i] * steps_per_mm[at] : -kRaised_mm[at - 2] * steps_per_mm[2];
    wiring.motors.push_back(
        {.name = kNames[at], .start_steps = std::round(start_steps)});
    wiring.inputs.push_back({std::string(kNames[at]) + "_STOP",
                             {.kind = PinSensor::Kind::kSwitch, .motor = i}});
  }
  wiring.inputs.push_back({"PROBE", {.kind = PinSensor::Kind::kProbe}});
  return wiring;
}

std::string PrinterCfgOfTripleZ(const Machine& machine, const std::string& serial) {
  const AxisDrawing& x = machine.axis(Axis::kX);
  const AxisDrawing& z = machine.axis(Axis::kZ);
  std::string text =
      klipper::BeginningOfCfg(machine.name, serial) +
      klipper::PrinterCfg({.is_corexy = machine.kind->drive_map() != nullptr,
                           .max_velocity_mm_s = x.max_feed_mm_s,
                           .max_accel_mm_s2 = x.acceleration_mm_s2,
                           .max_z_velocity_mm_s = z.max_feed_mm_s,
                           .max_z_accel_mm_s2 = z.acceleration_mm_s2});
  for (const Axis axis : {Axis::kX, Axis::kY}) text += HeadCfg(machine, axis);
  for (int screw = 0; screw < kNumScrews; ++screw) text += ScrewCfg(machine, screw);
  return text + LevellingCfg(machine);
}

}  // namespace caltwin
