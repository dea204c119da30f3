#pragma once

#include <optional>
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
  bool has_endstop = true;  ///< Of its own; else it stops with the first of its rail.
  /// Where the carriage may go and homes; nullopt: what follows another motor.
  struct Rail {
    double min_mm = 0, max_mm = 0, endstop_mm = 0;
    double homing_mm_s = 50;
  };
  std::optional<Rail> rail{};
};

/// [printer] of a machine with one motor or more for each of x, y and z.
struct PrinterText {
  bool is_corexy = false;
  double max_velocity_mm_s = 0, max_accel_mm_s2 = 0;
  double max_z_velocity_mm_s = 0, max_z_accel_mm_s2 = 0;
};

/// The first line and what is the same of every machine.
std::string BeginningOfCfg(const std::string& machine, const std::string& serial);

std::string PrinterCfg(const PrinterText& printer);

/// [stepper_...]; what else it has is appended.
std::string StepperCfg(const StepperText& stepper);

/// A number without the noise of its last bits, at most nine digits.
std::string CfgNumber(double value);

}  // namespace klipper
}  // namespace caltwin
