#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "sim/base/distribution.h"
#include "sim/base/yaml.h"
#include "sim/machine/artefact.h"
#include "sim/machine/machine.h"
#include "sim/measure/instrument.h"

namespace caltwin {

/// A number that is neither an effect nor a setting, and that a study draws anew for
/// each machine.
struct VariedNumber {
  /// "instruments.probe.sigma_um", "built.probe.hysteresis_mm",
  /// "built.artefacts.block.least_um".
  std::string name{};
  Distribution value = 0.0;
};

/// Whether a name is one of these, by how it begins.
bool IsVariedNumber(const std::string& name);

/// Reads one. Names:
///   instruments.ID.sigma_um | resolution_um | u_um   of an instrument that there is;
///                                                    calibration is told it too
///   built.probe.hysteresis_mm                        calibration keeps to the drawing
///   built.artefacts.ID.least_um | middle_um | largest_um
///       true minus certified size of a 1-2-3 block that there is; calibration keeps to
///       the certificate
VariedNumber ReadVariedNumber(const std::string& name,
                              const YamlValue& value,
                              const Instruments& instruments,
                              const std::vector<Artefact>& artefacts);

/// @name With what is drawn, each number from a stream of its own
Instruments DrawInstruments(Instruments instruments,
                            const std::vector<VariedNumber>& varied,
                            std::uint64_t seed,
                            std::uint64_t sample);
std::vector<Artefact> DrawArtefacts(std::vector<Artefact> artefacts,
                                    const std::vector<VariedNumber>& varied,
                                    std::uint64_t seed,
                                    std::uint64_t sample);
/// As `injected` of a table, in the order given.
std::vector<std::pair<std::string, double>> DrawnNumbers(
    const Machine& drawing,
    const std::vector<VariedNumber>& varied,
    std::uint64_t seed,
    std::uint64_t sample);
/// The machine as built; a hysteresis stays below the pre-travel.
Machine DrawBuilt(Machine drawing,
                  const std::vector<VariedNumber>& varied,
                  std::uint64_t seed,
                  std::uint64_t sample);

}  // namespace caltwin
