#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "sim/base/distribution.h"
#include "sim/base/rng.h"
#include "sim/base/yaml.h"
#include "sim/effects/injected.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// A machine as a file gives it: the drawing and, where the file is an extension
/// (`extends: machine.yaml`), what diagnosis found the machine to differ by.
struct MachineFile {
  Machine machine{};
  std::vector<InjectedSpec> effects{};
  /// Lines of a baseline that an extension was fitted beside (`scale.x`: ppm).
  std::map<std::string, double> baseline{};
  std::vector<std::string> notes{};  ///< What a person should know of it.
  std::vector<std::string> draws{};  ///< Of its distributions, what Faults::Note says.
  /// Contents of every file it is made of, one after the other: itself, what it
  /// extends, its model.
  std::string verbatim{};
};

/// Reads a machine file or an extension of one, which may extend another. Of an
/// extension's effects `sd`, `probability` and `rivals` are read and dropped; the
/// tables of `unknown` become effects too; a base that is not the one `extends_sha256`
/// was taken of becomes a note. Throws InputError, of a delta too: only what asks for
/// any machine can have one.
MachineFile ReadMachineFile(const std::filesystem::path& file);
/// The same of every machine that has a tip: deltas and triple-Z printers too, but not
/// of single motors.
MachineFile ReadMachineWithTip(const std::filesystem::path& file);
/// The same of every machine.
MachineFile ReadAnyMachineFile(const std::filesystem::path& file);

/// One setting that a scenario or truth file gives, perhaps still to be drawn.
struct SettingSpec {
  std::string key{};           ///< "steps_per_mm", ... or "tip_radius_mm".
  std::optional<Axis> axis{};  ///< Or the drive of that index; none: of the probe.
  Distribution value = 0.0;
};

/// Reads `settings: {steps_per_mm: {x: }, backlash_mm: , probe_deflection_mm: ,
/// tip_radius_mm: }`, numbers or distributions.
std::vector<SettingSpec> ReadSettingSpecs(YamlMap map,
                                          const MachineKind& kind = *CartesianKind());

/// `settings` with what the specs say, each drawn from its own stream.
Settings DrawSettings(Settings settings,
                      const std::vector<SettingSpec>& specs,
                      std::uint64_t seed,
                      std::uint64_t sample);

/// A truth file: the `effects` and `settings` of a scenario, nothing else.
struct TruthFile {
  std::vector<InjectedSpec> effects{};
  std::vector<SettingSpec> settings{};
};
TruthFile ReadTruthFile(const std::filesystem::path& file, const Machine& machine);

}  // namespace caltwin
