#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "sim/base/distribution.h"
#include "sim/base/yaml.h"
#include "sim/effects/effect.h"

namespace caltwin {

/// An effect as a scenario or truth file names it, its values perhaps still to be
/// drawn.
struct InjectedSpec {
  int effect = 0;
  std::string axis{};
  std::vector<Distribution> values{};  ///< In the declared order.
  Place place{};
};

/// Reads `effects: {cause.axis: {parameter: value}}` strictly: unknown causes, axes and
/// parameters are faults with a suggestion, numbers must lie within the declared
/// bounds; a parameter left out is neutral. `pitch_map.x` has `knots_mm` and
/// `values_um`, two lists of one length.
std::vector<InjectedSpec> ReadEffects(YamlMap map, const Machine& machine);

/// The same of entries picked from such a map.
std::vector<InjectedSpec> ReadEffects(
    const std::vector<std::pair<std::string, YamlValue>>& entries,
    const Machine& machine);

/// Adds a fault for each effect on an artefact that is none of `ids`.
void RefuseUnknownArtefacts(const std::vector<InjectedSpec>& specs,
                            const std::vector<std::string>& ids,
                            Faults* faults);

/// A list of ascending numbers, at least one.
std::vector<double> ReadKnots(const YamlValue& list);

/// One machine's values: each drawn from its own stream, named by cause, axis and
/// parameter, so that they do not depend on which other effects exist; clamped to the
/// declared bounds.
std::vector<Injected> DrawEffects(const std::vector<InjectedSpec>& specs,
                                  std::uint64_t seed,
                                  std::uint64_t sample);

/// `cause.axis`, followed by `.parameter` where the cause has several.
std::string ParameterName(int effect, std::string_view axis, std::size_t parameter);

/// The built, absolute value of one parameter on this machine: injected, or neutral.
/// `probe_pretravel.x` is the mean of both senses where they were injected apart.
double BuiltValue(const Machine& machine,
                  const std::vector<Injected>& effects,
                  int effect,
                  std::string_view axis,
                  std::size_t parameter);

}  // namespace caltwin
