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

std::string StepperCfg(const StepperText& stepper) {
  return fmt::format(
      "\n[{0}]\n"
      "step_pin: {1}_STEP\n"
      "dir_pin: {1}_DIR\n"
      "full_steps_per_rotation: {2}\n"
      "microsteps: {3}\n"
      "rotation_distance: {4}\n"
      "endstop_pin: {1}_STOP\n",
      stepper.section,
      stepper.pin,
      CfgNumber(stepper.full_steps_per_rev),
      CfgNumber(stepper.microsteps),
      CfgNumber(stepper.mm_per_rev));
}

}  // namespace klipper
}  // namespace caltwin
