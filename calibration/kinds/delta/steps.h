#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/base/yaml.h"

namespace caltwin {

/// A delta's procedures.
inline constexpr std::array<std::string_view, 4> kDeltaProcedures = {
    "g33", "rrf_least_squares", "klipper_descent", "delta_joint"};

/// What is known of one unknown before anything is touched.
struct DeltaPrior {
  int knob = 0;
  /// In the knob's unit, as the table of results has it: of a setting its value. None:
  /// as the settings are.
  std::optional<double> value{};
  double sd = 0;
};

/// One entry of a delta's `calibrate:`.
struct DeltaStep {
  std::string name{};        ///< g33, rrf_least_squares, klipper_descent, delta_joint.
  std::string variant{};     ///< as_published | corrected (g33).
  int points = 0;            ///< Touches, or G33's P; 0: the procedure's own.
  std::string words{};       ///< G33's other letters, as G-code: " C0.01 F3 T".
  double reduced_mm = 0;     ///< Of g33: what its letter R takes off the radius.
  int factors = 6;           ///< Of rrf_least_squares.
  std::vector<int> knobs{};  ///< Of delta_joint: its unknowns.
  std::vector<DeltaPrior> priors{};  ///< Of delta_joint, beside what knobs have.
  bool makes_mesh = false;           ///< Of what the settings leave (delta_joint).
  bool reads_rods = false;           ///< By calliper, each rod (delta_joint).
  /// By calliper, the distances of a calibration print (delta_joint, klipper_descent).
  bool reads_print = false;
};

/// Reads the options of one of kDeltaProcedures.
DeltaStep ReadDeltaStep(const std::string& name, YamlMap* map);

}  // namespace caltwin
