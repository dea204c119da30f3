#pragma once

#include "scenarios/kinds/z_station_wire.h"
#include "tools/commands/twin_options.h"

namespace caltwin {

/// What is true of the station that the files in `named` name. Throws InputError; of
/// truths with what acts by time too, which a wire of single commands has not: it would
/// not act.
ZStation BuiltStation(const TwinOptions& named);

/// A simulated head over its switch and bed, with a controller that speaks Klipper's
/// z_calibration and believes the station's drawing.
class SimulatedStation {
 public:
  /// Reads the files that `named` names. Throws InputError; of truths with what acts by
  /// time too, which a wire of single commands has not: it would not act.
  explicit SimulatedStation(const TwinOptions& named);

  Link& link() { return wire_; }
  void Wipe() { twin_.Wipe(); }
  /// A feeler under the nozzle, where it stands now.
  std::optional<double> Gap_mm(ZStationClient* client) {
    const auto read = ReadFeeler(klipper_, twin_, client);
    return read ? std::optional(read->gap_mm) : std::nullopt;
  }

 private:
  struct Parts {
    ZStation station{};
    ZCalibrationConfig config{};
  };
  static Parts PartsOf(const TwinOptions& named);
  SimulatedStation(const Parts& parts, const TwinOptions& named);

  ZStationTwin twin_;
  KlipperZ klipper_;
  EmulatedLink wire_{&klipper_};
};

}  // namespace caltwin
