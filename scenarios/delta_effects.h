#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/base/distribution.h"
#include "sim/base/yaml.h"
#include "sim/effects/injected.h"
#include "sim/machine/machine.h"
#include "sim/twin/delta_plant.h"

namespace caltwin {

/// One number of one effect of a delta: `rod_mismatch.a1: {length_error_mm: 0.3}`.
struct DeltaInjected {
  std::string name{};       ///< cause.axis, or the cause alone.
  std::string parameter{};  ///< As in CONTRACT.
  Distribution value = 0.0;
  Place place{};
};

/// Reads `effects:` of a delta's scenario.
std::vector<DeltaInjected> ReadDeltaEffects(YamlMap map);

/// A delta's truth file: `effects:` alone. Those that make its parts and its bed, and
/// those of the catalogue that do not (drives, probe, temperatures).
struct DeltaTruthFile {
  std::vector<DeltaInjected> parts{};
  std::vector<InjectedSpec> effects{};
};
DeltaTruthFile ReadDeltaTruthFile(const std::filesystem::path& file,
                                  const Machine& machine);

/// The machine that the effects make, their numbers drawn.
BuiltDelta DrawDelta(const std::vector<DeltaInjected>& effects,
                     const Machine& machine,
                     std::uint64_t seed,
                     std::uint64_t sample);

/// Every effect of a delta, for messages.
std::vector<std::string> DeltaEffectNames();

}  // namespace caltwin
