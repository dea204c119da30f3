#pragma once

#include <array>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/firmware/emulated_controller.h"
#include "sim/firmware/kinds/motor_stage/motion.h"
#include "sim/firmware/record_store.h"
#include "sim/link/gcode.h"

namespace caltwin {

/// What a motor controller comes out of the factory with.
struct MotorStageOptions {
  std::array<AxisCalibration, kNumMotorAxes> factory{};
  MotorMotion::Options motion{};
  std::int64_t clock_unix_s = 1'767'225'600;  ///< At power-up: 1 January 2026, UTC.
};

/// A controller of six motors that understands the G-code of docs/motor-axes.md.
///
/// - `G1 X10 F600` moves, and answers when the path is done; `H4` ends the move at the
///   axis' switch in that sense, `H5` at the next index pulse. `M400` waits for every
///   drive's position-complete signal.
/// - `M114` counters, `M119` switches as last read, `M814` what the drives say,
///   `M818` what the last emergency stop did.
/// - `M92 M201 M203 M206 M208 M425 M812 M813` are the nine fields of the record, `M500`
///   stores an axis' record, `M501` loads, `M502` forgets, `M504` prints the history,
///   `M505` logs.
class MotorStageFirmware final : public EmulatedController {
 public:
  /// @param rig, flash  borrowed; records in the flash are in force from the start
  MotorStageFirmware(const MotorStageOptions& options, MotorRig* rig, Flash* flash);

  Reply Execute(std::string_view line) override;

  double machine_time_s() const override { return motion_.time_s(); }
  const AxisCalibration& record(std::size_t axis) const { return axes_[axis].record; }
  bool is_homed(std::size_t axis) const { return axes_[axis].is_homed; }
  /// The rig's count that the axis calls zero.
  std::int64_t zero_count(std::size_t axis) const { return axes_[axis].zero; }

 private:
  struct Axis {
    AxisCalibration record{};
    std::int64_t zero = 0;
    double compensation_pulses = 0;  ///< Added to the target since the last reversal.
    bool is_homed = false;
    bool was_homed = false;   ///< Since power-up; its zero may be lost since.
    bool has_limits = false;  ///< Of its record: those of the factory do not count.
  };
  using Axes = std::vector<std::size_t>;

  void DistrustSteppersWithoutPower();
  Reply Obey(const GcodeCommand& command);
  Reply Move(const GcodeCommand& command);
  Reply Arrived(const GcodeCommand& command, const MotorMove& move);
  std::string LimitFault(std::size_t axis, double to_unit) const;
  Reply WaitForAll();
  Reply ForgetHome(const GcodeCommand& command);
  Reply SetZero(const GcodeCommand& command);
  Reply Positions() const;
  Reply Switches() const;
  Reply Drives(const GcodeCommand& command);
  Reply StopReports() const;
  Reply Delays(const GcodeCommand& command);
  Reply Field(const GcodeCommand& command);
  Reply Limits(const GcodeCommand& command);
  Reply Settings(const GcodeCommand& command);
  Reply StoreRecords(const GcodeCommand& command);
  void LoadRecord(std::size_t axis);
  Reply LoadRecords();
  Reply FactoryReset(const GcodeCommand& command);
  Reply History() const;
  Reply Note(const GcodeCommand& command);
  Reply Stop();
  Reply Clear();
  Reply Enable(const GcodeCommand& command, bool on);

  /// The axes whose letters stand in it; all where none does.
  static Axes Named(const GcodeCommand& command);
  double CommandedAt(std::size_t axis) const;
  double TargetFor(std::size_t axis, double to_unit);
  std::int64_t Now_unix_s() const;

  MotorStageOptions options_;
  MotorMotion motion_;
  Flash* flash_;
  RecordStore store_;
  std::array<Axis, kNumMotorAxes> axes_{};
  bool is_relative_ = false;
  double feed_unit_s_ = 10;
};

}  // namespace caltwin
