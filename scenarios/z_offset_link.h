#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/kinds/z_station/procedures.h"
#include "sim/kinds/z_station/station.h"

namespace caltwin {

/// The wire to a simulated printer with Klipper's z_calibration.
class KlipperZWire : public Link {
 public:
  explicit KlipperZWire(KlipperZ* klipper) : klipper_(klipper) {}
  Expected<std::vector<std::string>> Send(std::string_view line,
                                          std::chrono::milliseconds patience) override;

 private:
  KlipperZ* klipper_;
};

/// A feeler gauge's reading under the nozzle, where it stands.
struct FeelerReading {
  double height_mm = 0;  ///< Commanded, by a bed mesh in force too.
  double gap_mm = 0;     ///< In whole leaves of 0.01 mm.
};
/// nullopt where the controller does not say where it stands. Asks it GET_POSITION.
std::optional<FeelerReading> ReadFeeler(const KlipperZ& klipper,
                                        const ZStationTwin& twin,
                                        ZOffsetClient* client);

}  // namespace caltwin
