#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/firmware/firmware.h"

namespace caltwin {

/// What the firmware's Z can come down on.
enum class ZTouch {
  kNozzleOnSwitch,  ///< The nozzle's tip on the endstop switch.
  kBodyOnSwitch,    ///< The body of the attached probe's switch on it.
  kProbeOnBed       ///< The probe's trigger point on the print surface.
};

/// The mechanism under it: where each of them happens.
class ZStationPlant {
 public:
  virtual ~ZStationPlant() = default;
  /// Height of the head's carriage (in its own scale, + up) at the trigger; nullopt:
  /// none.
  virtual std::optional<double> Touch(ZTouch touch) = 0;
  virtual void Heat(char what, double temp_c) = 0;  ///< 'n'ozzle, 'b'ed, 'c'hamber.
};

/// printer.cfg as far as z_calibration reads it.
struct ZCalibrationConfig {
  double position_endstop_mm = 0;
  bool is_virtual_endstop = false;  ///< probe:z_virtual_endstop.
  double switch_offset_mm = 0.5;
  int samples = 1;
  double samples_tolerance_mm = 0.1;
  int samples_tolerance_retries = 0;
  bool takes_median = false;  ///< samples_result: median, else average.
  double probing_speed_mm_s = 5, lifting_speed_mm_s = 5;
  double retract_mm = 2;
  double position_min_mm = -5;
  std::string start_gcode{}, before_switch_gcode{}, end_gcode{};
};

/// The dozen commands of Klipper, with its z_calibration extension, that set a nozzle's
/// height: G28 G0 G1 G90 M400 M104 M140 M141 GET_POSITION SET_GCODE_OFFSET PROBE
/// PROBE_ACCURACY CALIBRATE_Z PROBE_Z_ACCURACY ATTACH_PROBE DETACH_PROBE. Refuses what
/// the extension refuses: a negative switch_offset, a virtual endstop, an endstop or
/// bed probed without what it needs.
class KlipperZ {
 public:
  KlipperZ(const ZCalibrationConfig& config, ZStationPlant* plant)
      : config_(config), plant_(plant) {}

  Reply Execute(std::string_view line);

  /// The carriage with the nozzle commanded to G-code height 0; nullopt: not homed.
  std::optional<double> CarriageAtNought_mm() const;
  const ZCalibrationConfig& config() const { return config_; }
  void SetSwitchOffset_mm(double value) { config_.switch_offset_mm = value; }
  double machine_time_s() const { return time_s_; }
  int touches() const { return touches_; }

 private:
  using Words = std::map<std::string, std::string>;
  struct Way {
    double down_mm_s = 5, up_mm_s = 5, up_mm = 2;
  };
  Reply Obey(const std::string& command, const Words& words);
  Reply Home();
  Reply Move(const Words& words);
  Reply CalibrateZ();
  Reply Accuracy(ZTouch touch, const Words& words);
  Reply SetOffset(const Words& words);
  Reply GetPosition() const;
  Reply ProbeBed();
  Reply Run(const std::string& macro);
  std::optional<std::string> Lacks(ZTouch touch) const;
  /// One touch in kinematic coordinates; nullopt: no trigger above position_min.
  std::optional<double> TouchOnce(ZTouch touch, const Way& way);
  /// As many as are configured, within their tolerance; else the error's text.
  std::optional<double> Touch(ZTouch touch, std::string* error);

  ZCalibrationConfig config_;
  ZStationPlant* plant_;
  bool is_homed_ = false, is_attached_ = false;
  double zero_mm_ = 0;  ///< Carriage less kinematic height, by homing.
  double z_mm_ = 0;     ///< Kinematic.
  double offset_mm_ = 0;
  double time_s_ = 0;
  int touches_ = 0;
};

/// The last line of CALIBRATE_Z.
std::string ZCalibrationLine(double endstop_mm,
                             double nozzle_mm,
                             double switch_mm,
                             double probe_mm,
                             double offset_mm);

/// The extension's formula: probe - (switch - nozzle + switch_offset).
double ZCalibrationOffset_mm(double nozzle_mm,
                             double switch_mm,
                             double probe_mm,
                             double switch_offset_mm);

}  // namespace caltwin
