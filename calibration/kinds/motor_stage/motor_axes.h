#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sim/link/link.h"
#include "sim/machine/kinds/motor_stage/drawing.h"

namespace caltwin {

/// What is known of a motor stage before it is asked anything.
struct MotorBench {
  Link* link = nullptr;
  Gauge* gauge = nullptr;  ///< `laser.x` reads where x's carriage is; none: nullptr.
  MotorStageDrawing drawing{};
  double gauge_sigma_unit = 0.0005;  ///< Standard uncertainty of one reading.
  double inertia_sigma = 0.03;       ///< Of the inertias, as a fraction.
  double stop_filter_s = 0.0005;     ///< Of the controller's emergency input;
  double stop_tick_s = 0.00025;      ///< brakes act at its next tick,
  double stepper_stop_s = 0.004;     ///< and so does its ramp for steppers.
  /// From the contact until brakes act, in the mean.
  double BrakesAfter_s() const { return stop_filter_s + stop_tick_s / 2; }
};

/// What M814 tells of an axis.
struct DriveSays {
  int index_edges = 0;
  std::optional<std::int64_t> index{};  ///< Counter at the last index pulse.
  double peak_a = 0;
  std::optional<double> half_way_s{};  ///< Of the last move.
  bool is_homed = false;
  bool was_homed = false;  ///< Since power-up.
};

/// What M818 tells of an axis.
struct StopSays {
  double standstill_s = 0, sd_s = 0;  ///< From the contact.
  double rests_s = 0;                 ///< When its counter had come to rest.
  double brakes_s = 0;                ///< Of it, until its brake acted.
  double told_unit_s = 0;  ///< The speed that it was told when the contact opened.
  double path_unit = 0;
  double peak_a = 0;
  bool stood = false;
  bool is_knocked = false;  ///< It did not brake evenly: pushed on by its load.
  bool is_disabled = false;
};

/// A condition of the published error handling, as it was met on the way.
struct MotorCondition {
  enum class Kind { kSwitchMissing, kIndexMissing, kMismatch, kBacklash, kBlocked };
  Kind kind = Kind::kBlocked;
  std::size_t axis = 0;
  std::string words{};    ///< For the log, without its speed.
  std::string remedy{};   ///< For the operator.
  bool can_move = false;  ///< Safe mode is slow then, else without power.
};
/// nullopt: another fault.
std::optional<MotorCondition> ConditionOf(const MachineFault& fault,
                                          const MotorStageDrawing& drawing);

/// Speaks to a motor controller (docs/motor-axes.md has its G-code). Axes are numbers
/// of kMotorAxisLetters, distances mm or deg, counts those of the motor's own counter
/// from the axis' zero. Faults are the controller's own words.
class MotorAxes {
 public:
  explicit MotorAxes(const MotorBench& bench) : bench_(bench) {}

  /// By so much from where it stands; waits for position complete.
  Expected<void> MoveBy(std::size_t axis, double by_unit, double speed_unit_s);
  Expected<void> MoveTo(std::size_t axis, double to_unit, double speed_unit_s);
  /// All those axes by so much along one path, without waiting for the drives.
  Expected<void> MoveTogether(const std::vector<std::size_t>& axes,
                              double by_unit,
                              double speed_unit_s);
  /// Until the switch that way acts; kNoTrigger where it does not.
  Expected<void> SeekSwitch(std::size_t axis, double by_unit, double speed_unit_s);
  Expected<void> SeekIndex(std::size_t axis, double by_unit, double speed_unit_s);
  Expected<void> WaitComplete() { return Do("M400"); }
  Expected<void> Enable(std::size_t axis, bool on);
  /// As it is, once the expander was asked twice.
  Expected<bool> IsPressed(std::size_t axis, bool is_min);
  Expected<std::int64_t> Count(std::size_t axis);
  Expected<DriveSays> Drive(std::size_t axis);
  Expected<void> ClearDrive(std::size_t axis);
  Expected<StopSays> LastStop(std::size_t axis);
  Expected<void> ArmRelay(double after_s);
  /// M999 and M17.
  Expected<void> Resume();
  /// M810: homing begins, no limit holds until there is a zero again.
  Expected<void> ForgetHome(std::size_t axis);
  /// That count is zero from now on.
  Expected<void> SetZero(std::size_t axis, std::int64_t count);
  /// A field of the record by its M-code (M92 M201 M203 M206 M425 M812 M813), in units.
  Expected<double> Field(int code, std::size_t axis);
  Expected<void> SetField(int code, std::size_t axis, double value);
  Expected<double> LowerLimit(std::size_t axis);  ///< Field(208) is the upper one.
  Expected<void> SetLimits(std::size_t axis, double min_unit, double max_unit);
  /// M816: the axis' moves begin so much later. Not stored.
  Expected<double> Delay_s(std::size_t axis);
  Expected<void> SetDelay_s(std::size_t axis, double delay_s);
  Expected<void> Store(std::size_t axis);
  /// A line of the controller's error log.
  Expected<void> Log(std::size_t axis, const std::string& text);

  const MotorBench& bench() const { return bench_; }
  const MotorAxisDrawing& drawing(std::size_t axis) const {
    return bench_.drawing.axes[axis];
  }

 private:
  Expected<std::vector<std::string>> Say(const std::string& line);
  Expected<void> Do(const std::string& line);
  Expected<double> NumberOf(const std::string& command, std::size_t axis);
  Expected<std::string> LineOf(const std::string& command, std::size_t axis);

  MotorBench bench_;
};

/// The number behind " KEY " in a line of words and numbers; nullopt: not there.
std::optional<double> NumberBehind(const std::string& line, const std::string& key);

}  // namespace caltwin
