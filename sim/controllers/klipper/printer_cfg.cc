#include "sim/controllers/klipper/printer_cfg.h"

#include <fmt/format.h>

namespace caltwin {
namespace klipper {

std::string CfgNumber(double value) {
  return fmt::format("{:.9g}", value);
}

std::string BeginningOfCfg(const std::string& machine, const std::string& serial) {
  return fmt::format(
      "# {}, as its firmware believes it to be. Made by `caltwin new klipper`.\n"
      "[mcu]\n"
      "serial: {}\n",
      machine,
      serial);
}

std::string PrinterCfg(const PrinterText& printer) {
  return fmt::format(
      "\n[printer]\nkinematics: {}\nmax_velocity: {}\nmax_accel: {}\n"
      "max_z_velocity: {}\nmax_z_accel: {}\n",
      printer.is_corexy ? "corexy" : "cartesian",
      CfgNumber(printer.max_velocity_mm_s),
      CfgNumber(printer.max_accel_mm_s2),
      CfgNumber(printer.max_z_velocity_mm_s),
      CfgNumber(printer.max_z_accel_mm_s2));
}

std::string StepperCfg(const StepperText& stepper) {
  std::string text = fmt::format(
      "\n[{0}]\n"
      "step_pin: {1}_STEP\n"
      "dir_pin: {1}_DIR\n"
      "full_steps_per_rotation: {2}\n"
      "microsteps: {3}\n"
      "rotation_distance: {4}\n",
      stepper.section,
      stepper.pin,
      CfgNumber(stepper.full_steps_per_rev),
      CfgNumber(stepper.microsteps),
      CfgNumber(stepper.mm_per_rev));
  if (stepper.has_endstop) text += fmt::format("endstop_pin: {}_STOP\n", stepper.pin);
  if (!stepper.rail) return text;
  return text + fmt::format(
                    "position_min: {}\nposition_max: {}\nposition_endstop: {}\n"
                    "homing_speed: {}\n",
                    CfgNumber(stepper.rail->min_mm),
                    CfgNumber(stepper.rail->max_mm),
                    CfgNumber(stepper.rail->endstop_mm),
                    CfgNumber(stepper.rail->homing_mm_s));
}

}  // namespace klipper
}  // namespace caltwin
