#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/base/yaml.h"
#include "sim/kinds/delta/effects.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// Bounds of a figure that a scenario expects.
struct Within {
  std::optional<double> above{};
  std::optional<double> below{};
};

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

struct DeltaExpectedValue {
  std::string name{};
  std::optional<double> truth_within{};
  std::optional<bool> identifiable{};
};

/// What a delta's scenario has of its own; about, machine, seed and fidelity are as in
/// any scenario.
struct DeltaScenario {
  DeltaEffects effects{};
  DeltaModel<double> settings{};  ///< What the firmware wrongly believes.
  /// settings: {probe_offset_mm: [x, y, z]}, sent as M851.
  Vec3<double> probe_offset_mm = Vec3<double>::Zero();
  double probe_sigma_mm = 0;  ///< instruments: {probe: {sigma_um: }}
  double calliper_sigma_mm = 0.02;
  std::vector<DeltaStep> calibrate{};
  std::string outcome = "recovers";
  std::vector<DeltaExpectedValue> values{};
  /// `height_error_mm.rms`, `.most`, `height_drift_mm` (from the first step to the
  /// last), `height_reversal_mm` (down against up, at most), `position_error_mm.p95`,
  /// `xy_scale_um_per_mm`, `said_mm`.
  std::vector<std::pair<std::string, Within>> figures{};
  std::vector<std::string> messages{};
};

/// Reads the keys of a delta's scenario that are its own. `machine_effects`: what an
/// extended machine file adds to the drawing. The twin that firmware drives has parts
/// and a bed, carriages with play among them: other effects of drives, heat and probe
/// are faults.
DeltaScenario ReadDeltaScenario(YamlMap* map,
                                const Machine& machine,
                                const std::vector<InjectedSpec>& machine_effects);

/// Entries of a delta's `calibrate:`.
std::vector<DeltaStep> ReadDeltaSteps(const YamlValue& list);

/// What is no part of the twin that firmware drives, as faults.
void RequireDeltaParts(const DeltaEffects& effects, Faults* faults);

/// The machine that the effects make, their numbers drawn.
BuiltDelta DrawDelta(const DeltaScenario& scenario,
                     const Machine& machine,
                     std::uint64_t seed,
                     std::uint64_t sample);

}  // namespace caltwin
