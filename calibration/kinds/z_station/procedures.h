#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "calibration/loop/outcome.h"
#include "sim/link/link.h"

namespace caltwin {

/// How far an offset may be from what three printed heights make of it [mm]: three
/// decimals, three of them.
inline constexpr double kPrintedHeights_mm = 0.0011;

/// The heights of one CALIBRATE_Z, as its last line states them [mm].
struct ZCalibrationReading {
  double nozzle_mm = 0, switch_mm = 0, probe_mm = 0, offset_mm = 0;
  /// The switch_offset that this offset was made with.
  double SwitchOffset_mm() const {
    return probe_mm - offset_mm - (switch_mm - nozzle_mm);
  }
};
/// Of "Z-CALIBRATION: ENDSTOP=.. NOZZLE=.. SWITCH=.. PROBE=.. --> OFFSET=..", or of
/// "Z-CALIBRATION: probe=.. - (switch=.. - nozzle=.. + switch_offset=..) --> new
/// offset=.."; nullopt where no line is one.
std::optional<ZCalibrationReading> ReadZCalibration(
    const std::vector<std::string>& lines);

/// Speaks to a printer with Klipper's z_calibration, and watches that nothing spoils
/// it.
class ZStationClient {
 public:
  /// Macros of printer.cfg's [z_calibration] that may home as well, too late: before
  /// the switch, so between two touches, and at the end.
  struct Macros {
    std::string before_switch_gcode{};
    std::string end_gcode{};
  };
  explicit ZStationClient(Link* link) : ZStationClient(link, Macros{}) {}
  ZStationClient(Link* link, Macros macros) : link_(link), macros_(std::move(macros)) {}

  Expected<std::vector<std::string>> Say(const std::string& line);
  /// G28; done, or what the machine said.
  ProcedureResult Home();
  /// The G-code offset of z in force (GET_POSITION); nullopt: it does not say.
  std::optional<double> GcodeBase_mm();
  /// Where the controller says that the nozzle is (GET_POSITION) [mm].
  struct Heights {
    double gcode_mm = 0;  ///< As commanded, over the G-code offset.
    double mesh_mm = 0;   ///< By which a bed mesh in force lifts it there.
  };
  std::optional<Heights> HeightsNow();
  /// The last CALIBRATE_Z's own line; nullopt: none was read.
  const std::optional<ZCalibrationReading>& last() const { return last_; }
  /// CALIBRATE_Z was sent, whatever came of it: it resets the offset of before.
  bool has_tried() const { return has_tried_; }
  bool is_calibrated() const { return is_calibrated_; }
  /// Z was homed (G28, G28 Z) after the last CALIBRATE_Z began, by hand or by one of
  /// its macros: its offset does not hold.
  bool is_spoilt() const { return is_spoilt_; }

 private:
  Link* link_;
  Macros macros_;
  bool has_tried_ = false, is_calibrated_ = false, is_spoilt_ = false;
  std::optional<ZCalibrationReading> last_{};
};

/// `result` ends with what the machine said; that nothing triggered is read from its
/// words.
void FailZStation(const MachineFault& fault, ProcedureResult* result);

/// CALIBRATE_Z, its line read, its formula checked, the offset asked back
/// (GET_POSITION). `switch_offset_mm`: as printer.cfg has it; nullopt: nobody said.
ProcedureResult RunZCalibration(ZStationClient* client,
                                std::optional<double> switch_offset_mm);

/// PROBE_Z_ACCURACY (or PROBE_ACCURACY): maximum, minimum, range, average, median,
/// standard deviation, and what they mean for an offset. Verdict: worn above 10 um.
ProcedureResult RunProbeAccuracy(ZStationClient* client, bool is_endstop, int samples);

}  // namespace caltwin
