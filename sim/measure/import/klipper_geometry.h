#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "sim/machine/kinds/delta/model.h"
#include "sim/measure/import/import.h"
#include "sim/measure/import/printer_cfg.h"

namespace caltwin {

/// What drives one tower, as a printer.cfg says it.
struct KlipperDrive {
  double step_mm = kUnknown;               ///< Carriage travel of a microstep.
  double rotation_distance_mm = kUnknown;  ///< Of the pulley, a turn.
  double full_steps_per_mm = kUnknown;
  double microsteps = kUnknown;
};

/// A delta as its printer.cfg believes it to be: what SAVE_CONFIG wrote wins over what
/// the person wrote, Klipper's own defaults stand for what neither says.
struct KlipperGeometry {
  DeltaModel<double> model{};
  std::array<KlipperDrive, 3> drive{};
  double print_radius_mm = kUnknown;
  std::vector<std::string> assumed{};
};

/// `gear_ratio: 80:16, 57:11` as turns of the motor a turn of the pulley; 1 where there
/// is none, or a fault.
double GearRatioOf(const PrinterCfg& cfg, const std::string& section, Faults* faults);

/// Reads [printer] and [stepper_a], [stepper_b], [stepper_c]. `step_mm`, if given, is
/// the step of all three. Without it drives may stay unknown: `step_mm` of the drive
/// says. nullopt, with faults, where the geometry is not whole or not possible.
std::optional<KlipperGeometry> ReadKlipperGeometry(const PrinterCfg& cfg,
                                                   std::optional<double> step_mm,
                                                   Faults* faults);

/// What a machine file says of a delta.
struct DeltaMachineText {
  std::string source{};  ///< The file it came from, for the comment on top.
  std::string name{};
  DeltaModel<double> model{};
  std::array<KlipperDrive, 3> drive{};
  double print_radius_mm = kUnknown;
};

/// The machine file (CONTRACT: `kinematics: delta`). Rod spacing, effector and joint
/// height are in no firmware's configuration; the text leaves them to the defaults.
std::string DeltaMachineYaml(const DeltaMachineText& text);

/// A name that a machine file takes, from a file's: letters, digits and underscores.
std::string MachineNameOf(const std::string& file);

}  // namespace caltwin
