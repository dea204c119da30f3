#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

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
  /// Macros of printer.cfg's [z_calibration] that may home as well, too late: before
  /// the switch, so between two touches, and at the end.
  struct Macros {
    std::string before_switch_gcode{};
    std::string end_gcode{};
  };
  explicit ZOffsetClient(Link* link) : ZOffsetClient(link, Macros{}) {}
  ZOffsetClient(Link* link, Macros macros) : link_(link), macros_(std::move(macros)) {}

  Expected<std::vector<std::string>> Say(const std::string& line);
  /// G28; done, or what the machine said.
  ProcedureResult Home();
  /// The G-code offset of z in force (GET_POSITION); nullopt: it does not say.
  std::optional<double> GcodeBase_mm();
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

/// CALIBRATE_Z, its line read, its formula checked, the offset asked back
/// (GET_POSITION). `switch_offset_mm`: as printer.cfg has it; nullopt: nobody said.
ProcedureResult RunZCalibration(ZOffsetClient* client,
                                std::optional<double> switch_offset_mm);

/// PROBE_Z_ACCURACY (or PROBE_ACCURACY): maximum, minimum, range, average, median,
/// standard deviation, and what they mean for an offset. Verdict: worn above 10 um.
ProcedureResult RunProbeAccuracy(ZOffsetClient* client, bool is_endstop, int samples);

/// The hands that a descent needs.
struct FeelerHands {
  /// The gap under the nozzle, which is commanded to that height [mm].
  std::function<std::optional<double>(double height_mm)> gap_mm{};
  std::function<bool()> wipe{};  ///< The nozzle, clean; false: nobody did.
};
struct SwitchOffsetOptions {
  bool is_as_published = false;
  /// In force; nullopt: the one that the last CALIBRATE_Z was made with.
  std::optional<double> in_force_mm{};
  /// Over the bed, where CALIBRATE_Z probes it: a tilted bed is elsewhere beside that.
  Eigen::Vector2d at_mm{117.5, 117.5};
  int calibrations = 5;  ///< Corrected: their scatter is that of the last.
};
/// The stepwise descent: G0 Z5, 3, 1, 0.5, 0.3, 0.1 with the gap measured under the
/// nozzle at each (a feeler gauge), and the switch_offset that would have made the last
/// one right. A step is left out where it would end less than 0.02 mm over the bed;
/// where a switch_offset below 0 would be needed for the first one to be safe, it
/// begins higher.
///
/// As published it goes by the calibration that is in force, and takes ooze on the
/// nozzle's tip for switch_offset: both leave the same gap. Corrected, the nozzle is
/// wiped and calibrated (CALIBRATE_Z) first, several times: what it tells is of their
/// mean, and as uncertain as they scatter.
ProcedureResult RunSwitchOffset(ZOffsetClient* client,
                                const SwitchOffsetOptions& options,
                                const FeelerHands& hands);

}  // namespace caltwin
