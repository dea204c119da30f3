#pragma once

#include <string>

namespace caltwin {
namespace klipper {

/// One motor's section of a printer.cfg.
struct StepperText {
  std::string section{};  ///< "stepper_z1"
  std::string pin{};      ///< "Z1": pins Z1_STEP, Z1_DIR, Z1_STOP.
  double full_steps_per_rev = 200;
  double microsteps = 16;
  double mm_per_rev = 4;
};

/// The first line and what is the same of every machine.
std::string BeginningOfCfg(const std::string& machine, const std::string& serial);

/// [stepper_...] up to its endstop's pin; what else it has is appended.
std::string StepperCfg(const StepperText& stepper);

/// A number without the noise of its last bits, at most nine digits.
std::string CfgNumber(double value);

}  // namespace klipper
}  // namespace caltwin
