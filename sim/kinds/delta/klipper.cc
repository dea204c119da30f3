#include "sim/kinds/delta/klipper.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/controllers/klipper/printer_cfg.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {
namespace {

using klipper::CfgNumber;

std::string PinName(int tower) {
  std::string name = TowerName(tower);
  name[0] = static_cast<char>(std::toupper(name[0]));
  return name;
}

std::string StepperSection(const Machine& machine, int tower) {
  const auto at = static_cast<std::size_t>(tower);
  const AxisDrawing& axis = machine.axes[at];
  const DeltaModel<double>& settings = DeltaOf(machine).settings;
  return klipper::StepperCfg({.section = "stepper_" + TowerName(tower),
                              .pin = PinName(tower),
                              .full_steps_per_rev = axis.full_steps_per_rev,
                              .microsteps = axis.microsteps,
                              .mm_per_rev = axis.lead_mm}) +
         fmt::format(
             "position_endstop: {}\narm_length: {}\nangle: {}\nhoming_speed: 50\n",
             CfgNumber(settings.endstop_mm[at]),
             CfgNumber(settings.arm_mm[at]),
             CfgNumber(DegFromRad(settings.angle_rad[at])));
}

}  // namespace

SteppedDelta::SteppedDelta(const Machine& machine,
                           const BuiltDelta& built,
                           bool is_physics,
                           std::uint64_t seed)
    : machine_(machine),
      built_(built),
      steps_per_mm_(TowerStepsPerMm(machine)),
      scatter_(seed, /*sample=*/0, "trigger_scatter") {
  if (is_physics) {
    world_ = std::make_unique<DeltaWorld>(WorldOfDelta(machine, built));
  }
}

bool SteppedDelta::ProbeActs(const Vec3<double>& motors_mm) {
  // Of tip over bed, play left out: beyond it nothing has to be looked at closely.
  constexpr double kClose_mm = 1;
  const auto pose = DeltaPoseOf(built_.build, motors_mm);
  if (!pose) return false;
  const Vec3<double> tip_mm =
      pose->nozzle_mm + delta_chain::Rotated(pose->cayley, built_.tip.AtTrigger_mm());
  const double above_mm = tip_mm[2] - built_.bed.Height_mm(tip_mm[0], tip_mm[1]);
  if (std::abs(above_mm) > kClose_mm) return above_mm < 0;
  const DeltaDescent straight = [&](double z_mm) {
    return Vec3<double>(motors_mm.array() - z_mm);
  };
  const auto touch_mm =
      TouchOfDelta_mm(world_.get(), machine_, built_, straight, -above_mm);
  return touch_mm && *touch_mm + early_mm_ >= 0;
}

bool SteppedDelta::Acts(const PinSensor& sensor, const Motors& steps) {
  if (sensor.kind == PinSensor::Kind::kSwitch) return steps[sensor.motor] <= 0;
  Vec3<double> motors_mm;
  for (int i = 0; i < kNumTowers; ++i) {
    motors_mm[i] = steps[i] / steps_per_mm_[static_cast<std::size_t>(i)];
  }
  return ProbeActs(motors_mm);
}

void SteppedDelta::Arm(const PinSensor& sensor) {
  if (sensor.kind != PinSensor::Kind::kProbe || built_.scatter_mm <= 0) return;
  early_mm_ = built_.scatter_mm * scatter_.Normal();
}

Wiring WiringOfDelta(const Machine& machine) {
  constexpr std::array kBelow_mm = {21.3, 33.7, 27.9};
  Wiring wiring;
  const std::array<double, 3> steps_per_mm = TowerStepsPerMm(machine);
  for (int i = 0; i < kNumTowers; ++i) {
    const auto at = static_cast<std::size_t>(i);
    wiring.motors.push_back(
        {.name = PinName(i),
         .sense = -1,
         .start_steps = std::round(kBelow_mm[at] * steps_per_mm[at])});
    wiring.inputs.push_back(
        {PinName(i) + "_STOP", {.kind = PinSensor::Kind::kSwitch, .motor = i}});
  }
  wiring.inputs.push_back({"PROBE", {.kind = PinSensor::Kind::kProbe}});
  return wiring;
}

std::string PrinterCfgOfDelta(const Machine& machine, const std::string& serial) {
  const DeltaDrawing& delta = DeltaOf(machine);
  const auto least = [&](double AxisDrawing::*member) {
    return std::ranges::min(machine.axes, {}, member).*member;
  };
  std::string text =
      klipper::BeginningOfCfg(machine.name, serial) +
      fmt::format(
          "\n[printer]\nkinematics: delta\nmax_velocity: {}\nmax_accel: {}\n"
          "max_z_velocity: {}\nminimum_z_position: -8\ndelta_radius: {}\n"
          "print_radius: {}\n",
          CfgNumber(least(&AxisDrawing::max_feed_mm_s)),
          CfgNumber(least(&AxisDrawing::acceleration_mm_s2)),
          CfgNumber(std::min(100.0, least(&AxisDrawing::max_feed_mm_s))),
          CfgNumber(MeanOfTowers(delta.settings.radius_mm)),
          CfgNumber(delta.print_radius_mm));
  for (int i = 0; i < kNumTowers; ++i) text += StepperSection(machine, i);
  // Neither touch nor move may leave the disc that the arms reach.
  text += fmt::format(
      "\n[probe]\n"
      "pin: PROBE\n"
      "z_offset: 0\n"
      "speed: 5\n"
      "\n[delta_calibrate]\n"
      "radius: {}\n"
      "speed: 80\n"
      "horizontal_move_z: 12\n",
      CfgNumber(0.9 * delta.print_radius_mm));
  return text;
}

}  // namespace caltwin
