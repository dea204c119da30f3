#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scenarios/expectation.h"
#include "scenarios/kind_scenario.h"
#include "scenarios/klipper/host.h"
#include "scenarios/linuxcnc/under_linuxcnc.h"
#include "scenarios/machine_file.h"
#include "scenarios/varied.h"
#include "sim/machine/artefact.h"
#include "sim/measure/instrument.h"
#include "sim/twin/twin.h"

namespace caltwin {

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
  AnyKindScenario kind{};  ///< What its machine's kind has beside the rest.
  std::vector<InjectedSpec> effects{};  ///< The machine file's own first.
  std::vector<SettingSpec> settings{};
  Instruments instruments{};
  std::vector<VariedNumber> varied{};  ///< A study's; none in a scenario file.
  std::vector<Artefact> artefacts{};
  FirmwareOptions firmware{};
  /// `controller: {klipper: ...}`: Klipper's own host drives the machine. An empty
  /// config: made of the machine.
  std::optional<KlipperHostOptions> klipper{};
  /// `controller: {linuxcnc: ...}`
  std::optional<UnderLinuxCnc> linuxcnc{};
  std::vector<CalibrationStep> calibrate{};
  Expectation expect{};
  std::vector<std::string> notes{};  ///< Of distributions (Faults::Note).
};

/// Reads and checks a scenario file; throws InputError with every fault.
Scenario ReadScenario(const std::filesystem::path& file);
/// The same from text; paths in it are relative to the folder of `name`.
Scenario ReadScenarioText(const std::string& text, const std::filesystem::path& name);

}  // namespace caltwin
