#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "calibration/loop/outcome.h"
#include "sim/link/link.h"

namespace caltwin {

/// The heights of one CALIBRATE_Z, as its last line states them [mm].
struct ZCalibrationReading {
  double endstop_mm = 0, nozzle_mm = 0, switch_mm = 0, probe_mm = 0, offset_mm = 0;
  /// The switch_offset that this offset was made with.
  double SwitchOffset_mm() const {
    return probe_mm - offset_mm - (switch_mm - nozzle_mm);
  }
};
/// Of "Z-CALIBRATION: ENDSTOP=.. NOZZLE=.. SWITCH=.. PROBE=.. --> OFFSET=.."; nullopt
/// where no line is one.
std::optional<ZCalibrationReading> ReadZCalibration(
    const std::vector<std::string>& lines);

/// Speaks to a printer with Klipper's z_calibration, and watches that nothing spoils
/// it.
class ZOffsetClient {
 public:
  /// @param end_gcode  of printer.cfg's [z_calibration], which may home as well
  explicit ZOffsetClient(Link* link, std::string end_gcode = "")
      : link_(link), end_gcode_(std::move(end_gcode)) {}

  Expected<std::vector<std::string>> Say(const std::string& line);
  /// G28 was sent after the last CALIBRATE_Z, or its own end_gcode homes: its offset no
  /// longer holds.
  bool is_spoilt() const { return is_spoilt_; }

 private:
  Link* link_;
  std::string end_gcode_;
  bool is_calibrated_ = false, is_spoilt_ = false;
};

/// CALIBRATE_Z, its line read, its formula checked, the offset asked back
/// (GET_POSITION). `switch_offset_mm`: as printer.cfg has it.
ProcedureResult RunZCalibration(ZOffsetClient* client, double switch_offset_mm);

/// PROBE_Z_ACCURACY (or PROBE_ACCURACY): maximum, minimum, range, average, median,
/// standard deviation, and what they mean for an offset. Verdict: worn above 10 um.
ProcedureResult RunProbeAccuracy(ZOffsetClient* client, bool is_endstop, int samples);

/// The stepwise descent: G0 Z5, 3, 1, 0.5, 0.3, 0.1 with the gap measured under the
/// nozzle at each (a feeler gauge), and the switch_offset that would have made the last
/// one right.
ProcedureResult RunSwitchOffset(ZOffsetClient* client,
                                double switch_offset_mm,
                                const std::function<std::optional<double>()>& gap_mm);

}  // namespace caltwin
