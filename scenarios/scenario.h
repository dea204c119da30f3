#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "calibration/procedures/catalog.h"
#include "scenarios/delta_scenario.h"
#include "scenarios/expectation.h"
#include "scenarios/external.h"
#include "scenarios/machine_file.h"
#include "scenarios/motor_scenario.h"
#include "scenarios/triple_z_scenario.h"
#include "scenarios/varied.h"
#include "scenarios/z_offset_scenario.h"
#include "sim/machine/artefact.h"
#include "sim/measure/instrument.h"
#include "sim/twin/twin.h"

namespace caltwin {

/// One entry of `calibrate:`: a procedure of the catalog, somebody else's program
/// (`external`), or lines of G-code sent as they are (`gcode`).
struct CalibrationStep {
  std::string name{};
  std::string variant{};  ///< As written; empty where the step says none.
  PreparedProcedure procedure{};
  std::optional<ExternalCommand> external{};
};

/// A trial: a machine with hidden errors, what is done to calibrate it, and what is
/// expected. This struct is the schema of scenario files; docs/scenarios.md and
/// `caltwin explain scenario` say it in words (scenarios/keys.h).
struct Scenario {
  std::filesystem::path file{};
  std::string verbatim{};
  std::string about{};
  MachineFile machine{};
  std::uint64_t seed = 1;
  Fidelity fidelity = Fidelity::kPhysics;
  std::vector<InjectedSpec> effects{};  ///< The machine file's own first.
  std::vector<SettingSpec> settings{};
  Instruments instruments{};
  std::vector<VariedNumber> varied{};  ///< A study's; none in a scenario file.
  std::vector<Artefact> artefacts{};
  FirmwareOptions firmware{};
  std::vector<CalibrationStep> calibrate{};
  Expectation expect{};
  std::optional<DeltaScenario> delta{};       ///< In place of all from `effects` on.
  std::optional<TripleZScenario> triple_z{};  ///< Likewise.
  std::optional<MotorScenario> motor{};       ///< Likewise; its machine is in it.
  std::optional<ZOffsetScenario> z_offset{};  ///< Likewise, where it has a `station`.
  std::vector<std::string> notes{};           ///< Of distributions (Faults::Note).
};

/// Reads and checks a scenario file; throws InputError with every fault.
Scenario ReadScenario(const std::filesystem::path& file);
/// The same from text; paths in it are relative to the folder of `name`.
Scenario ReadScenarioText(const std::string& text, const std::filesystem::path& name);

/// What a step of `calibrate` is made of, for any list of one-key maps.
/// A procedure by its name alone that cannot do without an axis gets `usual_axis`
/// ("x"), where that is not empty.
std::vector<CalibrationStep> ReadCalibrationSteps(const YamlValue& list,
                                                  const std::string& usual_axis = "");

}  // namespace caltwin
