#pragma once

#include <array>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "sim/firmware/emulated_controller.h"

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
  /// none. `at_mm`: where the probe is over the bed; the switch has a place of its own.
  virtual std::optional<double> Touch(ZTouch touch, const Eigen::Vector2d& at_mm) = 0;
  virtual void Heat(char what, double temp_c) = 0;  ///< 'n'ozzle, 'b'ed, 'c'hamber.
};

/// [bed_mesh]: a grid of heights over the bed, bilinear between, added to every move.
struct BedMeshConfig {
  Eigen::Vector2d min_mm{20, 20}, max_mm{215, 215};
  std::array<int, 2> count{3, 3};  ///< Along x and y.
  /// The point whose height the mesh calls 0, counted along x first, from min_mm.
  std::optional<int> relative_reference_index{};

  Eigen::Vector2d PointAt_mm(int index) const;
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
  double position_min_mm = -5, position_max_mm = 300;  ///< Of z.
  Eigen::Vector2d least_mm{0, 0}, most_mm{235, 235};   ///< Travel of x and y.
  std::optional<double> max_deviation_mm{};            ///< Larger offsets are refused.
  std::string start_gcode{}, before_switch_gcode{}, end_gcode{};
  std::optional<BedMeshConfig> bed_mesh{};
  /// Where CALIBRATE_Z probes the bed; none: the mesh's reference point, or without a
  /// mesh the middle of the bed.
  std::optional<Eigen::Vector2d> probe_bed_at_mm{};
  Eigen::Vector2d middle_mm{117.5, 117.5};
  Eigen::Vector2d dock_mm{10, 230};
  double probe_z_offset_mm = 0;  ///< [probe] z_offset: of a mesh without a reference.
};

/// When something was touched, and how warm it was told to be [degC].
struct ZCircumstances {
  double at_s = 0;  ///< Machine time.
  int homing = 0;   ///< Counted from 1.
  double nozzle_c = 20, bed_c = 20, chamber_c = 20;
};

/// One trigger of a switch, as the firmware counted it.
struct ZTouched {
  ZTouch touch = ZTouch::kNozzleOnSwitch;
  Eigen::Vector2d place_mm = Eigen::Vector2d::Zero();
  double height_mm = 0;  ///< Kinematic.
  double feed_mm_s = 0;
  ZCircumstances when{};
};

/// The dozen commands of Klipper, with its z_calibration extension, that set a nozzle's
/// height: G28 G0 G1 G21 G90 G91 M114 M400 M104 M140 M141 GET_POSITION
/// SET_GCODE_OFFSET PROBE PROBE_ACCURACY CALIBRATE_Z PROBE_Z_ACCURACY ATTACH_PROBE
/// DETACH_PROBE BED_MESH_CALIBRATE BED_MESH_CLEAR. Refuses what the extension refuses:
/// a negative switch_offset, a virtual endstop, a mesh without a point of reference, an
/// endstop or bed probed without what it needs. Places are those of the probe: its
/// offset from the nozzle in x and y is the firmware's own affair.
class KlipperZ final : public EmulatedController {
 public:
  KlipperZ(const ZCalibrationConfig& config, ZStationPlant* plant)
      : config_(config), plant_(plant), at_mm_(config.middle_mm) {}

  Reply Execute(std::string_view line) override;

  /// The carriage with the nozzle commanded to G-code height 0 over that place, the
  /// mesh added; nullopt: not homed.
  std::optional<double> CarriageAtNought_mm(const Eigen::Vector2d& at_mm) const;
  /// Where the head stands over the bed.
  const Eigen::Vector2d& at_mm() const { return at_mm_; }
  /// Where CALIBRATE_Z probes the bed; nullopt: a mesh, and no point of reference.
  std::optional<Eigen::Vector2d> BedPoint_mm() const;
  /// What the mesh in force adds there; 0 without one.
  double Mesh_mm(const Eigen::Vector2d& at_mm) const;
  const ZCalibrationConfig& config() const { return config_; }
  void SetSwitchOffset_mm(double value) { config_.switch_offset_mm = value; }
  double machine_time_s() const override { return now_.at_s; }
  int touches() const { return static_cast<int>(touched_.size()) + homings(); }
  /// Every touch since the start but those that homed.
  const std::vector<ZTouched>& touched() const { return touched_; }
  const ZCircumstances& now() const { return now_; }

 private:
  using Words = std::map<std::string, std::string>;
  struct Way {
    double down_mm_s = 5, up_mm_s = 5, up_mm = 2;
  };
  int homings() const { return now_.homing; }
  Reply Heat(const std::string& command, const Words& words);
  Reply Obey(const std::string& command, const Words& words);
  Reply Home();
  Reply Move(const Words& words);
  bool IsInRange(const Eigen::Vector2d& place_mm, double z_mm) const;
  Reply CalibrateZ();
  Reply Calibrate(const Eigen::Vector2d& bed_point_mm);
  Reply Accuracy(ZTouch touch, const Words& words);
  Reply SetOffset(const Words& words);
  Reply GetPosition() const;
  Reply GcodePosition() const;
  double GcodeZ_mm() const;  ///< As G-code has it: without offset and mesh.
  Reply ProbeBed();
  Reply CalibrateMesh();
  Reply Dock(bool attaches);
  void Travel(const Eigen::Vector2d& to_mm);
  Reply Run(const std::string& macro);
  std::optional<std::string> Lacks(ZTouch touch) const;
  /// One touch in kinematic coordinates; nullopt: no trigger above position_min.
  std::optional<double> TouchOnce(ZTouch touch, const Way& way);
  /// As many as are configured, within their tolerance; else the error's text.
  std::optional<double> Touch(ZTouch touch, std::string* error);

  ZCalibrationConfig config_;
  ZStationPlant* plant_;
  bool is_homed_ = false, is_attached_ = false, is_calibrating_ = false;
  bool is_relative_ = false;
  double zero_mm_ = 0;                   ///< Carriage less kinematic height, by homing.
  double z_mm_ = 0;                      ///< Kinematic.
  std::optional<double> rests_at_mm_{};  ///< Where PROBE left the knob on the bed.
  double offset_mm_ = 0;
  Eigen::Vector2d at_mm_;
  std::vector<double> mesh_mm_{};  ///< By point; empty: none in force.
  ZCircumstances now_{};
  std::vector<ZTouched> touched_{};
};

/// "!! text", as Klipper refuses.
Reply KlipperRefusal(const std::string& text);

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
