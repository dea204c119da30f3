#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "calibration/kinds/triple_z/procedures.h"
#include "scenarios/delta_scenario.h"
#include "scenarios/external.h"
#include "sim/base/yaml.h"
#include "sim/effects/injected.h"
#include "sim/kinds/triple_z/plant.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// One entry of a triple-Z printer's `calibrate:`.
struct TripleZStep {
  std::string name{};  ///< plane_tilt, ..., move_triple_z, gcode, external.
  TripleZOptions options{};
  Eigen::Vector2d at_mm = Eigen::Vector2d::Zero();  ///< Of move_triple_z: the nozzle,
  Vec3<double> heights_mm = Vec3<double>::Zero();   ///< and the screws.
  std::vector<std::string> lines{};                 ///< Of gcode.
  std::optional<ExternalCommand> external{};
};

/// What a triple-Z printer's scenario has of its own; about, machine, seed and fidelity
/// are as in any scenario.
struct TripleZScenario {
  std::vector<InjectedSpec> effects{};
  Pivots<double> believed_mm{};  ///< settings: {screws_at_mm: {z1: [x, y]}}, as M671.
  double steps_per_mm = 800;     ///< settings: {steps_per_mm: {z: }}
  double probe_sigma_mm = 0;     ///< instruments: {probe: {sigma_um: }}
  std::vector<TripleZStep> calibrate{};
  std::string outcome = "recovers";
  std::vector<DeltaExpectedValue> values{};
  /// `level_error_mm.mean`, `.max`, `flatness_mm.rms`, `machine_time_s`,
  /// `predicted_factor`, `validation_mm.mean`, `hold_out_mm.mean`,
  /// `position_error_mm.p95`.
  std::vector<std::pair<std::string, Within>> figures{};
  std::vector<std::string> messages{};
};

/// Reads the keys of a triple-Z printer's scenario that are its own. `machine_effects`:
/// what an extended machine file adds to the drawing. Effects that want temperatures or
/// times are faults: nothing here has them.
TripleZScenario ReadTripleZScenario(YamlMap* map,
                                    const Machine& machine,
                                    const std::vector<InjectedSpec>& machine_effects);

/// The machine that the effects make, their numbers drawn.
BuiltTripleZ DrawTripleZ(const TripleZScenario& scenario,
                         const Machine& machine,
                         std::uint64_t seed,
                         std::uint64_t sample);

/// The steps of `calibrate:`.
std::vector<TripleZStep> ReadTripleZSteps(const YamlValue& list);

}  // namespace caltwin
