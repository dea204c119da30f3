#pragma once

#include <string>
#include <utility>

#include <fmt/format.h>

#include "calibration/motor_axes/procedures.h"

namespace caltwin {

/// Part of the slow speed with which a corrected homing looks at its switch again.
inline constexpr double kSecondLook = 0.1;

/// A motor procedure on its way: what it said and did.
class MotorDoing {
 public:
  MotorDoing(std::string name, const MotorOptions& options, MotorAxes* axes)
      : name_(std::move(name)), options_(options), axes_(axes) {}

  void Say(std::string text) { done_.result.messages.push_back(std::move(text)); }
  void Warn(const std::string& text) {
    ++done_.found.warnings;
    Say("warning: " + text);
  }
  /// Logged in the controller, and said.
  void Log(std::size_t axis, const std::string& text) {
    Say("logged: " + text);
    logged_ = {axis, text};
    Did(axes_->Log(axis, text));
  }
  /// Logged (once, where the last try logged the same), and the operator called;
  /// nothing more is done with the axis.
  void Alert(std::size_t axis, const std::string& text) {
    ++done_.found.alerts;
    if (logged_ != std::pair(axis, text)) Log(axis, text);
    Say("ALERT: operator wanted: " + text);
    done_.result.ending = Ending::kRefused;
  }
  /// The axis without power.
  void SafeOff(std::size_t axis) {
    ++done_.found.safe_modes;
    Did(axes_->Enable(axis, false));
    Say(fmt::format("safe mode: {} is switched off", MotorAxisName(axis)));
  }
  /// The axis at a tenth of its highest speed from now on.
  void SafeSlow(std::size_t axis) {
    ++done_.found.safe_modes;
    const double most_unit_s = axes_->drawing(axis).max_velocity_unit_s / 10;
    Did(axes_->SetField(203, axis, most_unit_s));
    Say(fmt::format("safe mode: {} moves at no more than {:g} {}/s",
                    MotorAxisName(axis),
                    most_unit_s,
                    axes_->drawing(axis).unit()));
  }
  void Step(const std::string& quantity,
            double before,
            double after,
            Verdict verdict,
            const std::string& message) {
    done_.result.steps.push_back(
        {.procedure = name_,
         .variant = options_.is_as_published ? "as_published" : "corrected",
         .iteration = done_.found.retries + 1,
         .name = quantity,
         .before = before,
         .after = after,
         .verdict = verdict,
         .message = message});
  }
  void Found(std::string name, std::string unit, double value, double sd) {
    done_.result.estimates.push_back({.name = std::move(name),
                                      .unit = std::move(unit),
                                      .value = value,
                                      .sd = sd,
                                      .identifiable = true});
  }
  void Found(std::string name, std::string unit, const Uncertain& estimate) {
    done_.result.estimates.push_back({.name = std::move(name),
                                      .unit = std::move(unit),
                                      .value = estimate.value,
                                      .sd = estimate.sd,
                                      .identifiable = estimate.identifiable,
                                      .budget = estimate.budget});
  }
  void Confess(const std::string& statement, const std::string& name) {
    done_.result.observability.push_back({statement, {{name, 1.0}}});
    done_.result.ending = Ending::kConfounded;
  }
  void Fail(const MachineFault& fault) {
    done_.result.fault = fault.reply;
    const auto kind = fault.kind;
    done_.result.ending = kind == MachineFault::Kind::kNoTrigger  ? Ending::kNoTrigger
                          : kind == MachineFault::Kind::kLinkLost ? Ending::kLinkLost
                          : kind == MachineFault::Kind::kAlarm    ? Ending::kAlarm
                                                                  : Ending::kRefused;
    Say("the machine said: " + fault.reply);
  }
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

  MotorResult& done() { return done_; }
  const MotorOptions& options() const { return options_; }
  MotorAxes& axes() { return *axes_; }
  const MotorAxes& axes() const { return *axes_; }
  MotorResult Take() { return std::move(done_); }

 private:
  std::string name_;
  const MotorOptions& options_;
  MotorAxes* axes_;
  std::pair<std::size_t, std::string> logged_{};  // Last.
  MotorResult done_{};
};

/// Brings the axis to its MIN switch, or does what is to be done where that fails:
///
/// Where the axis is blocked on its way it goes to MAX: farther than the switches are
/// apart, it stood beyond MIN, whose switch is dead then; else something is in the way.
/// Each try is logged and the next at half the speed; then the operator is called and
/// the axis switched off.
/// @return the speed with which it was found
std::optional<double> FindMinSwitch(std::size_t axis, MotorDoing* doing);

/// Warns where the record's turn (M812 / M92) differs from the drawn one by more than a
/// percent: every distance that homing goes, and the turns it counts, would be off.
void HintAtScale(std::size_t axis,
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
/// deg]: the switch's own scatter, and the expander's, which looks once a period.
double SwitchSigma(const MotorBench& bench, double speed_unit_s);

/// The same, taken apart, of the mean of `touches`.
std::vector<Contribution> SwitchBudget(const MotorBench& bench,
                                       double speed_unit_s,
                                       int touches = 1);

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

/// The gap that the controller compensates (M425), known to a pulse; not identifiable
/// where that is 0: then the procedure says that half of one would come in here.
std::optional<Uncertain> CompensatedGap(std::size_t axis,
                                        const std::string& quantity,
                                        MotorDoing* doing);

}  // namespace caltwin
