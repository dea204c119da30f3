#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/base/distribution.h"
#include "sim/base/yaml.h"
#include "sim/effects/injected.h"
#include "sim/kinds/delta/plant.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// One number of what the catalogue does not have, because no row tells it (endstops,
/// radius) or the twin takes it as a part of its own (the bed's shapes, the trigger).
struct DeltaInjected {
  std::string name{};       ///< cause.axis, or the cause alone.
  std::string parameter{};  ///< As in CONTRACT.
  Distribution value = 0.0;
  Place place{};
};

/// `effects:` of a delta's scenario or truth file.
struct DeltaEffects {
  std::vector<DeltaInjected> parts{};
  std::vector<InjectedSpec> effects{};  ///< Of the catalogue.
};
DeltaEffects ReadDeltaEffects(YamlMap map, const Machine& machine);
DeltaEffects ReadDeltaTruthFile(const std::filesystem::path& file,
                                const Machine& machine);

/// The machine that effects make, their numbers drawn, and those that do not make it:
/// what drives, probe and temperatures do.
struct DrawnDelta {
  BuiltDelta built{};
  std::vector<Injected> others{};
};
DrawnDelta DrawDelta(const DeltaEffects& effects,
                     const Machine& machine,
                     std::uint64_t seed,
                     std::uint64_t sample);

/// Every effect of a delta, for messages.
std::vector<std::string> DeltaEffectNames();

}  // namespace caltwin
