#pragma once

#include <vector>

#include "sim/measure/import/console_line.h"
#include "sim/measure/import/import.h"

namespace caltwin {

/// What Klipper's z_calibration plugin prints: readings of the nozzle and of the probe
/// switch's body on one pin, and a hint for the height that Z is homed to. The distance
/// of the two on the pin is fixed in the toolhead; where it changes, one of the touches
/// was another.
class SwitchStory {
 public:
  /// One calibration.
  struct Calibration {
    double nozzle_mm = 0, body_mm = 0, probe_mm = 0;
    double offset_mm = kUnknown;   ///< As it came out.
    double endstop_mm = kUnknown;  ///< As configured; kUnknown: not printed.
    int line = 0;
  };

  /// Whether the line was a calibration or its hint.
  bool Take(const ConsoleLine& line, int number);
  const std::vector<Calibration>& calibrations() const { return all_; }
  void Tell(Imported* imported) const;

 private:
  void TellDistance(Imported* imported) const;
  void TellHint(Imported* imported) const;
  /// Whether Z was homed to another height between two of them.
  bool HasOtherEndstops() const;

  /// The endstop as configured, of the calibration that gave this offset.
  struct Hint {
    double offset_mm = 0, endstop_mm = 0;
  };
  std::vector<Calibration> all_{};
  std::vector<Hint> hints_{};
};

}  // namespace caltwin
