#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/kinds/z_station/procedures.h"
#include "sim/kinds/z_station/record.h"
#include "sim/kinds/z_station/station.h"

namespace caltwin {

/// The gap under the nozzle, where it stands;
/// nullopt where the controller does not say where that is. Asks it GET_POSITION.
std::optional<FeelerReading> ReadFeeler(const KlipperZ& klipper,
                                        const ZStationTwin& twin,
                                        ZStationClient* client);

/// What a program from outside has at a simulated station: the wire, watched by
/// `client`; a feeler gauge (`feeler`); hands that wipe the nozzle when asked to.
class StationHands : public Link, public Gauge, public Operator {
 public:
  /// All are borrowed.
  StationHands(const KlipperZ* klipper, ZStationTwin* twin, ZStationClient* client)
      : klipper_(klipper), twin_(twin), client_(client) {}
  Expected<std::vector<std::string>> Send(std::string_view line,
                                          std::chrono::milliseconds patience) override;
  Expected<double> Read_mm(std::string_view id) override;
  Expected<void> Zero(std::string_view id) override;
  Expected<void> Do(const Act& act) override;

 private:
  const KlipperZ* klipper_;
  ZStationTwin* twin_;
  ZStationClient* client_;
};

}  // namespace caltwin
