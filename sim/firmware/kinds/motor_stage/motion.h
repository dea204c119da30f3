#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sim/firmware/kinds/motor_stage/rig.h"

namespace caltwin {

/// A trapezoidal path of a given length that can be cut short: speed rises by
/// `acceleration` to `speed` and falls by the same to 0 at the end.
class TrapezoidPath {
 public:
  TrapezoidPath() = default;
  /// All above 0, but the length, which may be 0.
  TrapezoidPath(double length, double speed, double acceleration);

  double At(double t_s) const;
  double duration_s() const { return stop_at_s_ ? stopped_s_ : duration_s_; }
  /// Slows down from where it is at `t_s`, by `deceleration`.
  void StopFrom(double t_s, double deceleration);

 private:
  double length_ = 0, speed_ = 1, acceleration_ = 1;
  double ramp_s_ = 0, duration_s_ = 0;
  std::optional<double> stop_at_s_{};
  double stop_from_ = 0, stop_speed_ = 0, stop_deceleration_ = 1, stopped_s_ = 0;
};

/// A move of several axes along one path, in pulses.
struct MotorMove {
  std::array<double, kNumMotorAxes> to_pulses{};  ///< Of axes not `moves`: unused.
  std::array<bool, kNumMotorAxes> moves{};
  /// Of the axis that goes farthest, in units of travel.
  double length_unit = 0, speed_unit_s = 1, acceleration_unit_s2 = 1;
  enum class Until { kArrived, kSwitch, kIndex };
  Until until = Until::kArrived;
  std::size_t watched = 0;
  SwitchEnd end = SwitchEnd::kMin;
};

/// How a move ended.
struct MotorArrival {
  bool found = false;  ///< The switch or index that ended it.
  std::optional<std::size_t> blocked{};
  bool stopped = false;  ///< By the emergency stop.
};

/// What an emergency stop did to an axis, as the controller saw it.
struct StopReport {
  double standstill_s = 0;   ///< From the contact; a stepper's: when its field stood.
  double sd_s = 0;           ///< Of that; a stepper's is known.
  double rests_s = 0;        ///< When its counter had come to rest.
  double brakes_at_s = 0;    ///< From the contact until brakes and ramps began.
  double told_pulses_s = 0;  ///< Its speed when the contact opened.
  double path_pulses = 0;
  double peak_a = 0;
  bool is_done = false;
  bool is_knocked = false;  ///< Its load pushed it on: it did not brake evenly.
};

/// The real-time part of a motor controller: every tick it tells each drive where to
/// be, samples switches over the expander, takes what was latched at index pulses,
/// watches currents.
class MotorMotion {
 public:
  struct Options {
    std::array<bool, kNumMotorAxes> is_servo{};
    std::array<double, kNumMotorAxes> limit_a{};
    double poll_s = 0.005, transfer_s = 0.0004;
    double blocked_s = 0.03;        ///< So long at the current limit: blocked.
    double stop_filter_s = 0.0005;  ///< Of the emergency stop's input.
    double stepper_stop_s = 0.004;  ///< Steppers are ramped down in that time.
  };
  /// One axis as the controller has it. Counts are the rig's, since power-up.
  struct AxisState {
    bool is_enabled = true;
    double target_pulses = 0;
    double delay_s = 0;  ///< Start of its moves, against the others'.
    double in_position_s = 0;
    double at_limit_s = 0;
    double peak_a = 0;
    double last_drive_pulses = 0;  ///< Told for the last tick,
    double told_pulses_s = 0;      ///< and how fast that is.
    bool index_enabled = true;     ///< Else its edges are not latched (M813).
    std::int64_t index_edges = 0;
    std::optional<std::int64_t> last_index{};
    std::optional<double> half_way_s{};        ///< Of the last move, from its start.
    std::optional<double> in_position_at_s{};  ///< Likewise; set by WaitInPosition.
    StopReport stop{};
  };

  /// @param rig  borrowed
  MotorMotion(const Options& options, MotorRig* rig);

  MotorArrival Perform(const MotorMove& move);
  /// Waits until every servo is within 2 pulses for 5 ms; the axis that is not after
  /// `patience_s`.
  std::optional<std::size_t> WaitInPosition(double patience_s);
  void Wait(double seconds);
  void Enable(std::size_t axis, bool on);
  /// The relay on the emergency stop's input, so long after the next move begins.
  void ArmRelay(double after_s) { relay_s_ = after_s; }
  void DisarmRelay() { relay_s_.reset(); }
  /// Servos brake with all their current, steppers are ramped down; what stands is
  /// switched off when all do, and all refuse to move until ClearStop.
  /// @param since_s  the input's contact opened so long ago, by its time stamp
  void EmergencyStop(double since_s = 0);
  void ClearStop() { is_stopped_ = false; }

  bool is_stopped() const { return is_stopped_; }
  double time_s() const { return time_s_; }
  /// As last read over the expander.
  bool KnownPressed(std::size_t axis, SwitchEnd end) const;
  AxisState& axis(std::size_t i) { return axes_[i]; }
  const AxisState& axis(std::size_t i) const { return axes_[i]; }
  std::int64_t Count(std::size_t i) const { return rig_->Count(i); }

 private:
  using Pins = std::array<std::array<bool, 2>, kNumMotorAxes>;
  /// One move on its way.
  struct Under {
    TrapezoidPath path{};
    std::array<double, kNumMotorAxes> from{}, way{};
    std::array<std::int64_t, kNumMotorAxes> from_count{};
    std::array<std::int64_t, kNumMotorAxes> edges_before{};
    double length = 1, t_s = 0;
  };
  /// One axis on its way to a standstill.
  struct Slowing {
    double told_pulses_s = 0;            ///< As it went when the contact opened.
    std::int64_t from = 0;               ///< Its counter then,
    std::vector<std::int64_t> counts{};  ///< from where the brakes act, every tick,
    std::int64_t near = 0;               ///< and within a pulse of that
    double still_s = 0;                  ///< for so long.
  };
  using Slowings = std::array<Slowing, kNumMotorAxes>;
  void Tick(const RigDrives& drives);
  int FilterTicks(double since_s) const;
  RigDrives Stopping(double braked_s, const Slowings& slowings);
  void WatchStop(bool brakes, Slowings* slowings);
  StopReport ReportOf(std::size_t i, const Slowing& slowing, double brakes_at_s) const;
  RigDrives Holding() const;
  void Poll();
  void Watch(std::size_t i, const RigDrive& drive);
  bool IsFound(const MotorMove& move, const Under& under) const;
  RigDrives DrivesOf(const MotorMove& move, const Under& under);
  void NoteHalfWay();
  std::optional<std::size_t> Blocked() const;
  void HoldHere();

  Options options_;
  MotorRig* rig_;
  double tick_s_;
  double time_s_ = 0;
  double next_poll_s_ = 0, known_at_s_ = 0;
  Pins sampled_{}, known_{};
  bool has_news_ = false;
  std::array<AxisState, kNumMotorAxes> axes_{};
  std::array<std::int64_t, kNumMotorAxes> count_before_{};
  Under last_{};
  std::optional<double> relay_s_{};
  bool is_stopped_ = false;
};

}  // namespace caltwin
