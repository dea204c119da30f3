#include <cmath>

#include "calibration/motor_axes/doing.h"
#include "sim/base/mutant.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kUsualBackOff_unit = 5;
constexpr double kClear_unit = 0.3;  // Before a fine touch: beyond any hysteresis.
constexpr double kGentle = 0.5;      // Of the acceleration, on the way to a switch.
constexpr double kLostSigmas = 6;

/// Where a switch was seen [pulses].
struct Seen {
  double pulses = 0;
  double sd_unit = 0;
  std::vector<Contribution> budget{};
};

/// Which switch, and how fast the axis came to stand beyond it.
struct AtSwitch {
  int sense = -1;  ///< Of the way to it.
  double came_unit_s = 0;
};

// So often from so near, so slowly: the mean.
std::optional<Seen> TouchFinely(std::size_t axis,
                                const AtSwitch& at,
                                double pulses_per_unit,
                                MotorDoing* doing) {
  MotorAxes& axes = doing->axes();
  const MotorOptions& o = doing->options();
  const auto late_unit = SeenLate(axis, o.fine_unit_s, doing);
  const auto came_late_unit = SeenLate(axis, at.came_unit_s, doing);
  if (!late_unit || !came_late_unit) return std::nullopt;
  // It may stand farther beyond by half the expander's period. From too near the switch
  // would not have opened, and would be seen at once.
  const double beyond_unit =
      *came_late_unit + at.came_unit_s * axes.bench().drawing.poll_s / 2;
  Seen seen;
  const int touches = Mutant("stepper_home_last_touch", o.touches, 1);
  for (int i = 0; i < touches; ++i) {
    const double back_unit = kClear_unit + (i == 0 ? beyond_unit : 0);
    const double to_unit = 5 * kClear_unit + back_unit;
    const bool is_done =
        doing->Did(axes.MoveBy(axis, -at.sense * back_unit, 10 * o.fine_unit_s)) &&
        doing->Did(axes.SeekSwitch(axis, at.sense * to_unit, o.fine_unit_s)) &&
        doing->Did(axes.WaitComplete());
    if (!is_done) return std::nullopt;
    const auto count = doing->Got(axes.Count(axis));
    if (!count) return std::nullopt;
    seen.pulses += static_cast<double>(*count) / touches;
  }
  seen.pulses -= at.sense * *late_unit * pulses_per_unit;
  seen.sd_unit = SwitchSigma(axes.bench(), o.fine_unit_s) / std::sqrt(touches);
  seen.budget = SwitchBudget(axes.bench(), o.fine_unit_s, touches);
  return seen;
}

// The published second approach, at part of the speed.
std::optional<Seen> SecondTouch(std::size_t axis,
                                double slow_unit_s,
                                MotorDoing* doing) {
  MotorAxes& axes = doing->axes();
  const MotorOptions& o = doing->options();
  const double back_unit = o.back_off_unit.value_or(kUsualBackOff_unit);
  const double speed_unit_s = o.second * slow_unit_s;
  const bool is_done =
      doing->Did(axes.MoveBy(axis, back_unit, slow_unit_s)) &&
      doing->Did(axes.SeekSwitch(axis, -2 * back_unit, speed_unit_s)) &&
      doing->Did(axes.WaitComplete());
  if (!is_done) return std::nullopt;
  const auto count = doing->Got(axes.Count(axis));
  if (!count) return std::nullopt;
  return Seen{static_cast<double>(*count),
              SwitchSigma(axes.bench(), speed_unit_s),
              SwitchBudget(axes.bench(), speed_unit_s)};
}

// Of an axis that was homed before: its switch is where it was, or steps were lost.
void TellLostSteps(std::size_t axis,
                   const Seen& seen,
                   double pulses,
                   MotorDoing* doing) {
  const MotorAxisDrawing& d = doing->axes().drawing(axis);
  const double off_unit = seen.pulses / pulses + doing->options().final_back_off_unit;
  const bool has_lost =
      std::abs(off_unit) >= kLostSigmas * std::sqrt(2.0) * seen.sd_unit;
  doing->done().found.lost_unit = has_lost ? off_unit : 0;
  if (!has_lost) {
    doing->Say(fmt::format("{} had lost no steps: {:+.1f} {} from its home",
                           MotorAxisName(axis),
                           UmFromMm(off_unit),
                           d.fine_unit()));
    return;
  }
  const double cycles = off_unit * d.full_steps_per_rev / d.lead_unit / 4;
  doing->Log(axis,
             fmt::format("{} had lost {:.3f} {}, {:.1f} magnetic cycles of four full "
                         "steps",
                         MotorAxisName(axis),
                         off_unit,
                         d.unit(),
                         cycles));
}

// Half the acceleration for as long as it lives.
class GentleStart {
 public:
  GentleStart(std::size_t axis, MotorDoing* doing) : axis_(axis), doing_(doing) {
    const auto usual = doing->Got(doing->axes().Field(201, axis));
    if (!usual) return;
    usual_unit_s2_ = *usual;
    doing->Did(doing->axes().SetField(201, axis, kGentle * *usual));
  }
  bool End() {
    return usual_unit_s2_ > 0 &&
           doing_->Did(doing_->axes().SetField(201, axis_, usual_unit_s2_));
  }

 private:
  std::size_t axis_;
  MotorDoing* doing_;
  double usual_unit_s2_ = 0;
};

}  // namespace

MotorResult RunStepperHome(MotorAxes* axes, const MotorOptions& options) {
  MotorDoing doing("stepper_home", options, axes);
  const std::size_t axis = options.axes.front();
  const MotorAxisDrawing& d = axes->drawing(axis);
  const auto pulses = doing.Got(axes->Field(92, axis));
  const auto says = doing.Got(axes->Drive(axis));
  const auto per_rev = doing.Got(axes->Field(812, axis));
  if (!pulses || !says || !per_rev) return doing.Take();
  if (!doing.Did(axes->ForgetHome(axis))) return doing.Take();
  HintAtScale(axis, *pulses, *per_rev, &doing);
  GentleStart gentle(axis, &doing);
  const auto slow_unit_s = FindMinSwitch(axis, &doing);
  std::optional<Seen> seen;
  if (slow_unit_s) seen = SecondTouch(axis, *slow_unit_s, &doing);
  if (!gentle.End() || !seen) return doing.Take();
  if (!options.is_as_published) {
    seen = TouchFinely(axis,
                       {.sense = -1, .came_unit_s = options.second * *slow_unit_s},
                       *pulses,
                       &doing);
  }
  if (!seen) return doing.Take();
  if (says->was_homed) TellLostSteps(axis, *seen, *pulses, &doing);
  const double zero = seen->pulses + options.final_back_off_unit * *pulses;
  const double slow = *slow_unit_s;
  const bool is_kept =
      doing.Did(axes->SetZero(axis, std::llround(zero))) &&
      doing.Did(axes->MoveTo(axis, 0, slow)) &&
      doing.Did(
          axes->MoveTo(axis, options.safe_unit - options.final_back_off_unit, slow)) &&
      doing.Did(axes->SetField(206, axis, options.final_back_off_unit)) &&
      doing.Did(axes->Store(axis));
  if (!is_kept) return doing.Take();
  const std::string name = "home_offset." + MotorAxisName(axis);
  doing.Step(name,
             0,
             options.final_back_off_unit,
             Verdict::kApplied,
             fmt::format("zero stands {:g} {} from the switch, told to {:.1f} {}",
                         options.final_back_off_unit,
                         d.unit(),
                         UmFromMm(seen->sd_unit),
                         d.fine_unit()));
  const auto gap_unit = CompensatedGap(axis, "home_offset", &doing);
  if (!gap_unit) return doing.Take();
  doing.Found(
      name, d.unit(), OfCarriage(options.final_back_off_unit, *gap_unit, seen->budget));
  return doing.Take();
}

MotorResult RunTravelLimits(MotorAxes* axes, const MotorOptions& options) {
  MotorDoing doing("travel_limits", options, axes);
  const std::size_t axis = options.axes.front();
  const MotorAxisDrawing& d = axes->drawing(axis);
  const auto pulses = doing.Got(axes->Field(92, axis));
  const auto offset_unit = doing.Got(axes->Field(206, axis));
  const auto says = doing.Got(axes->Drive(axis));
  if (!pulses || !offset_unit || !says) return doing.Take();
  if (!says->is_homed) {
    doing.Fail({.reply = MotorAxisName(axis) + " is not homed: home it first"});
    return doing.Take();
  }
  const double speed_unit_s = options.slow * d.max_velocity_unit_s;
  const double reach_unit = 1.2 * (d.max_switch_unit - d.min_switch_unit);
  if (!doing.Did(axes->MoveTo(axis, 0, speed_unit_s))) return doing.Take();
  const auto found = axes->SeekSwitch(axis, reach_unit, speed_unit_s);
  if (!found) {
    doing.Alert(axis,
                fmt::format("end switch MAX of {} not detected ({})",
                            MotorAxisName(axis),
                            found.error().reply));
    doing.SafeSlow(axis);
    return doing.Take();
  }
  if (!doing.Did(axes->WaitComplete())) return doing.Take();
  const auto count = doing.Got(axes->Count(axis));
  if (!count) return doing.Take();
  std::optional<Seen> seen{{static_cast<double>(*count),
                            SwitchSigma(axes->bench(), speed_unit_s),
                            SwitchBudget(axes->bench(), speed_unit_s)}};
  if (!options.is_as_published) {
    seen =
        TouchFinely(axis, {.sense = +1, .came_unit_s = speed_unit_s}, *pulses, &doing);
  }
  if (!seen) return doing.Take();
  const double travel_unit = seen->pulses / *pulses;
  const double low_unit = std::min(0.0, options.margin_unit - *offset_unit);
  const double high_unit = travel_unit - options.margin_unit;
  const bool is_kept =
      doing.Did(axes->SetLimits(axis, low_unit, high_unit)) &&
      doing.Did(axes->MoveTo(axis, (low_unit + high_unit) / 2, speed_unit_s)) &&
      doing.Did(axes->Store(axis));
  if (!is_kept) return doing.Take();
  const std::string name = "travel." + MotorAxisName(axis);
  doing.Step(
      name,
      d.max_unit,
      travel_unit,
      Verdict::kApplied,
      fmt::format("working range {:.3f} .. {:.3f} {}", low_unit, high_unit, d.unit()));
  const auto gap_unit = CompensatedGap(axis, "travel", &doing);
  if (!gap_unit) return doing.Take();
  doing.Found(name, d.unit(), OfCarriage(travel_unit, *gap_unit, seen->budget));
  return doing.Take();
}

}  // namespace caltwin
