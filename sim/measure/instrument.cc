#include "sim/measure/instrument.h"

namespace caltwin {

Instruments ReadInstruments(YamlMap map) {
  Instruments instruments;
  for (const auto& [id, value] : map.Entries()) {
    YamlMap entry = value.Map();
    Instrument& instrument = instruments[id];
    instrument.kind = entry.TextOr("kind", id);
    instrument.sigma_um = entry.NumberOr("sigma_um", 0, {0, 1e5});
    instrument.resolution_um =
        entry.NumberOr("resolution_um", 0, Instrument::kResolution_um);
    instrument.u_um = entry.NumberOr("u_um", 0, {0, 1e5});
    entry.NoMoreKeys();
  }
  return instruments;
}

}  // namespace caltwin
