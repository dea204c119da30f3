#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "calibration/kinds/motor_stage/procedures.h"

namespace caltwin {

/// Part of the slow speed with which a corrected homing looks at its switch again.
inline constexpr double kSecondLook = 0.1;

/// A motor procedure on its way: what it said and did.
///
/// Faults that are conditions of the published error handling (switch not detected,
/// index missing, position mismatch, excessive backlash, motion blocked) end it with a
/// line in the controller's log, the operator called and the axis in safe mode, also
/// where nothing tries again.
class MotorDoing {
 public:
  MotorDoing(std::string name, const MotorOptions& options, MotorAxes* axes)
      : name_(std::move(name)), options_(options), axes_(axes) {}

  void Say(Message message) { done_.result.messages.push_back(std::move(message)); }
  void Warn(const std::string& text) {
    ++done_.found.warnings;
    Say("warning: " + text);
  }
  /// Logged in the controller, and said.
  void Log(std::size_t axis, const std::string& text);
  /// Logged (unless the last line said so), and the operator called; nothing more is
  /// done with the axis.
  void Alert(std::size_t axis, const std::string& text);
  /// The axis without power.
  void SafeOff(std::size_t axis);
  /// The axis at a tenth of its highest speed from now on, and after the next power-up.
  void SafeSlow(std::size_t axis);

  /// That condition was met: TrySlower tries again, else it ends here.
  void Meet(MotorCondition condition) {
    condition_ = std::move(condition);
    done_.result.ending = Ending::kRefused;
  }
  /// Does `attempt(speed)` until it gets there. A condition that it meets is logged,
  /// and it is tried again at half the speed, `retries` times; then the operator is
  /// called and the axis put in safe mode.
  /// @return what attempt returned last: true or a value where it got there
  template <typename Attempt>
  auto TrySlower(double speed_unit_s, Attempt attempt)
      -> decltype(attempt(speed_unit_s)) {
    for (int left = options_.retries;; --left, speed_unit_s /= 2) {
      auto got = attempt(speed_unit_s);
      if (got || !condition_) return got;
      LogCondition(speed_unit_s);
      if (left == 0) {
        GiveUp();
        return got;
      }
      TryAgainAt(speed_unit_s / 2);
    }
  }

  void Step(MotorDone step);
  void Found(Estimate estimate) {
    done_.result.estimates.push_back(std::move(estimate));
  }
  void Found(const std::string& name, const std::string& unit, const Uncertain& value);
  void Confess(const std::string& statement, const std::string& name) {
    done_.result.observability.push_back({statement, {{name, 1.0}}});
    done_.result.ending = Ending::kConfounded;
  }
  /// What another procedure found and did on the way, but for its estimates, which are
  /// not what this one is asked; its ending too where it is not done.
  bool Absorb(MotorResult inner);
  void Fail(const MachineFault& fault);
  template <typename T>
  std::optional<T> Got(Expected<T> value) {
    if (value) return *std::move(value);
    Fail(value.error());
    return std::nullopt;
  }
  bool Did(const Expected<void>& done) {
    if (!done) Fail(done.error());
    return done.has_value();
  }
  /// Fails where the axis is not homed.
  bool IsHomed(std::size_t axis);
  /// The highest speed in force: the drawing's, or what M203 has below that.
  std::optional<double> TopSpeed_unit_s(std::size_t axis);
  /// `medium` of what the slowest of the options' axes can.
  std::optional<double> CommonSpeed_unit_s();

  MotorResult& done() { return done_; }
  const MotorOptions& options() const { return options_; }
  MotorAxes& axes() { return *axes_; }
  const MotorAxes& axes() const { return *axes_; }
  /// A field of the record that holds until Store or Take puts it back, so that it is
  /// never stored. Asked for again, what was first there is put back.
  bool SetForNow(int code, std::size_t axis, double value);
  /// A servo reacts as soon as it can for now: a delay that axis_sync set (M816) would
  /// have it stop the later behind a switch.
  bool WithoutDelay(std::size_t axis);
  /// What SetForNow has set stays as it is from now on.
  void KeepAsItIs(int code, std::size_t axis);
  bool PutBack();
  /// What was set for now is put back, and the record stored.
  bool Store(std::size_t axis);
  MotorResult Take();

 private:
  void LogCondition(double speed_unit_s);
  void TryAgainAt(double speed_unit_s);
  void GiveUp();

  std::string name_;
  const MotorOptions& options_;
  MotorAxes* axes_;
  std::map<std::pair<int, std::size_t>, double> for_now_{};  // What was there before.
  std::optional<MotorCondition> condition_{};                // Met, not yet seen to.
  std::pair<std::size_t, std::string> logged_{};             // Last.
  MotorResult done_{};
};

/// Brings the axis to its MIN switch, at that speed. Where it is blocked on its way it
/// goes to MAX: farther than the switches are apart, it stood beyond MIN, whose switch
/// is dead then; else something is in the way.
bool FindMinSwitch(std::size_t axis, double speed_unit_s, MotorDoing* doing);

/// Fails where an axis that fast is not stopped between a switch and its hard stop.
/// `option`: whose speed that is.
bool StopsBehindASwitch(std::size_t axis,
                        double speed_unit_s,
                        MotorDoing* doing,
                        std::string_view option = "slow");

/// On to the next index, slowly; back, and again at half the speed where none comes.
/// @return the counter there
std::optional<std::int64_t> FindIndex(std::size_t axis,
                                      double lead_unit,
                                      double speed_unit_s,
                                      MotorDoing* doing);

/// A stepper that is homed on the way gets the zero that it had: as far from its switch
/// as M206 says, where it says so.
bool KeepHomeOffset(std::size_t axis, MotorOptions* home, MotorDoing* doing);

/// The axis has its zero so much farther to + than its limits (M208) were measured
/// from: they go along. Nothing where none are in force.
bool ShiftLimits(std::size_t axis, double farther_unit, MotorDoing* doing);

/// Hunting an index goes towards +: comes back from the upper end of the travel (its
/// limit, M208), so that two and a half turns are left. Wants a homed axis.
bool MakeRoom(std::size_t axis, MotorDoing* doing);

/// Warns where the record's turn (M812 / M92) differs from the drawn one by more than
/// 0.1 %: every distance, and the turns counted, would be off. Fails beyond 10 %.
bool MayHomeAtScale(std::size_t axis,
                    double pulses_per_unit,
                    double pulses_per_rev,
                    MotorDoing* doing);

/// How far beyond a switch an axis stands that was stopped by it, in the mean [mm,
/// deg]:
///
///   late = v (poll / 2 + transfer) + v^2 / (2 a)
///
/// the expander's period and bus, and the way to a standstill with the acceleration in
/// force. Neglects the servo's lag (less than a millisecond of v).
std::optional<double> SeenLate(std::size_t axis,
                               double speed_unit_s,
                               MotorDoing* doing);

/// Standard deviation of where an axis is seen to pass a switch at that speed [mm,
/// deg]: the switch's own scatter as drawn, and the expander's, which looks once a
/// period.
double SwitchSigma(const MotorBench& bench, std::size_t axis, double speed_unit_s);

/// The same, taken apart, of one look.
std::vector<Contribution> SwitchBudget(const MotorBench& bench,
                                       std::size_t axis,
                                       double speed_unit_s);

/// A way by the counter, from or to where a switch closed, as the carriage's own in the
/// middle of its gap [mm, deg]:
///
///   way - b / 2
///
/// Towards MIN (home_offset, from there to zero) the carriage leads its motor by half
/// the gap b, towards MAX (travel, from zero) it lags: either way the counter says
/// more.
/// @param gap_unit  not identifiable (nobody measured one): nothing is taken off
Uncertain OfCarriage(double way_unit,
                     const Uncertain& gap_unit,
                     std::vector<Contribution> budget);

/// Whether M425 may hold a gap at all: up to a fifth of a turn. The published procedure
/// stores the way that it was told to go.
bool MayBeAGap(double gap_unit, std::size_t axis, const MotorDoing& doing);

/// The gap that the controller compensates (M425), known to a pulse; not identifiable
/// where that is 0: then the procedure says that half of one would come in here.
std::optional<Uncertain> CompensatedGap(std::size_t axis,
                                        const std::string& quantity,
                                        MotorDoing* doing);

}  // namespace caltwin
