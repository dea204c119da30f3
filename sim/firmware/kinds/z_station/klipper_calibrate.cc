// The z_calibration extension: three touches and the offset they give.
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "sim/firmware/kinds/z_station/klipper.h"

namespace caltwin {

std::string ZCalibrationLine(double endstop_mm,
                             double nozzle_mm,
                             double switch_mm,
                             double probe_mm,
                             double offset_mm) {
  return fmt::format(
      "Z-CALIBRATION: ENDSTOP={:.3f} NOZZLE={:.3f} SWITCH={:.3f} PROBE={:.3f} --> "
      "OFFSET={:.6f}",
      endstop_mm,
      nozzle_mm,
      switch_mm,
      probe_mm,
      offset_mm);
}

double ZCalibrationOffset_mm(double nozzle_mm,
                             double switch_mm,
                             double probe_mm,
                             double switch_offset_mm) {
  return probe_mm - (switch_mm - nozzle_mm + switch_offset_mm);
}

Reply KlipperZ::CalibrateZ() {
  if (config_.switch_offset_mm < 0) {
    return KlipperRefusal(
        "Option 'switch_offset' in section 'z_calibration' must have minimum of 0.0");
  }
  if (config_.is_virtual_endstop) {
    return KlipperRefusal("probe:z_virtual_endstop is not supported for Z calibration");
  }
  if (!is_homed_) return KlipperRefusal("Must home axes first");
  const auto bed_point_mm = BedPoint_mm();
  if (!bed_point_mm) {
    return KlipperRefusal(
        "Either the relative_reference_index of bed_mesh or a probe position on the "
        "bed is required");
  }
  if (is_calibrating_) return KlipperRefusal("Macro CALIBRATE_Z called recursively");
  is_calibrating_ = true;
  const Reply reply = Calibrate(*bed_point_mm);
  is_calibrating_ = false;
  return reply;
}

Reply KlipperZ::Calibrate(const Eigen::Vector2d& bed_point_mm) {
  offset_mm_ = 0;  // A previous one is reset.
  if (const Reply started = Run(config_.start_gcode); started.error) return started;
  std::string error;
  std::array<double, 3> at_mm{};
  constexpr std::array kTouches = {
      ZTouch::kNozzleOnSwitch, ZTouch::kBodyOnSwitch, ZTouch::kProbeOnBed};
  for (std::size_t i = 0; i < kTouches.size(); ++i) {
    if (kTouches[i] == ZTouch::kBodyOnSwitch) {
      const Reply before = Run(config_.before_switch_gcode);
      if (before.error) return before;
    }
    if (const auto lacks = Lacks(kTouches[i])) return KlipperRefusal(*lacks);
    if (kTouches[i] == ZTouch::kProbeOnBed) Travel(bed_point_mm);
    const auto touched = Touch(kTouches[i], &error);
    if (!touched) return KlipperRefusal(error);
    at_mm[i] = *touched;
  }
  const double offset_mm =
      ZCalibrationOffset_mm(at_mm[0], at_mm[1], at_mm[2], config_.switch_offset_mm);
  const bool is_allowed =
      std::abs(offset_mm) <= config_.max_deviation_mm.value_or(std::abs(offset_mm));
  if (is_allowed) offset_mm_ = offset_mm;
  if (const Reply ended = Run(config_.end_gcode); ended.error) return ended;
  if (!is_allowed) {
    return KlipperRefusal(fmt::format("Offset is greater than allowed: {:.3f} > {:.3f}",
                                      std::abs(offset_mm),
                                      *config_.max_deviation_mm));
  }
  return {.lines = {ZCalibrationLine(
              config_.position_endstop_mm, at_mm[0], at_mm[1], at_mm[2], offset_mm_)}};
}

}  // namespace caltwin
