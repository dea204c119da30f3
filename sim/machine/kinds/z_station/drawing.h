#pragma once

#include <optional>
#include <string_view>

#include <Eigen/Core>

#include "sim/base/yaml.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// What a reading at a printer's station is of: the word of a row's `feature`.
enum class ZReading {
  kNozzleOnSwitch,  ///< "switch.nozzle": the nozzle's tip closes the endstop switch.
  kBodyOnSwitch,    ///< "switch.body": the body of the attached probe closes it.
  kProbeOnBed,      ///< "bed.probe": the probe's knob triggers on the print surface.
  kGapUnderNozzle   ///< "bed.gap": a gauge under the nozzle, calibrated just before.
};
/// "switch.nozzle" ...
std::string_view FeatureOf(ZReading reading);
std::optional<ZReading> ZReadingOf(std::string_view feature);

/// Nozzle, endstop switch and magnetic switch probe as drawn. The controller's heights
/// are those of the drawn nozzle's tip over the bare bed, + up:
///
///   nozzle on switch: switch,  body on switch: switch + body,
///   probe on bed: body + trigger   [mm]
struct ZStationDrawing {
  double switch_mm = 1.5;   ///< The endstop switch triggers so high over the bare bed.
  double body_mm = 6.5;     ///< The probe's body hangs so far below the tip.
  double trigger_mm = 0.5;  ///< Body over what its knob touches, at the trigger.
  Eigen::Vector2d switch_at_mm{120, 230};
  Eigen::Vector2d bed_at_mm{117.5, 117.5};  ///< Where the bed is probed.

  /// Commanded height of what is touched; of a gap 0.
  double Nominal_mm(ZReading reading) const;
  Eigen::Vector2d PlaceOf_mm(ZReading reading) const;
};

/// Reads `station: {switch_mm, body_mm, trigger_mm, switch_at_mm, bed_at_mm}`; what is
/// left out is as above.
ZStationDrawing ReadZStationDrawing(YamlMap* map);

/// The drawing of a printer's station, which the machine must be.
inline const ZStationDrawing& ZStationOf(const Machine& machine) {
  return *machine.Own<ZStationDrawing>();
}
inline ZStationDrawing& ZStationOf(Machine& machine) {
  return *machine.Own<ZStationDrawing>();
}

}  // namespace caltwin
