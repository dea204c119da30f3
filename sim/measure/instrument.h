#pragma once

#include <map>
#include <string>

#include "sim/base/yaml.h"

namespace caltwin {

/// A measuring instrument as scenario, plan and data header describe it.
struct Instrument {
  static constexpr Bounds kResolution_um{0, 1e5};

  std::string kind{};        ///< laser, dial, calliper, probe, ... a free word.
  double sigma_um = 0;       ///< Standard deviation of one reading.
  double resolution_um = 0;  ///< Readings are rounded to multiples of it; 0: not.
  double u_um = 0;           ///< Standard uncertainty of its scale or certificate.
};

/// By id. `probe` is the machine's touch probe (its sigma adds to every trigger).
using Instruments = std::map<std::string, Instrument>;

/// Reads `instruments: {id: {kind: , sigma_um: , resolution_um: , u_um: }}`; an id that
/// names a kind (laser, dial, calliper, probe) need not repeat it.
Instruments ReadInstruments(YamlMap map);

}  // namespace caltwin
