#include <cmath>

#include <fmt/format.h>

#include "calibration/kinds/motor_stage/switch_looks.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kUsualBackOff_unit = 5;
constexpr double kGentle = 0.5;  // Of the acceleration, on the way to a switch.
constexpr double kLostSigmas = 6;
constexpr double kFullSteps = 4;  // A magnetic cycle.

/// Where a switch was seen [pulses].
struct Seen {
  double pulses = 0;
  double sd_unit = 0;
  std::vector<Contribution> budget{};
};

/// The zero of before: so far from its switch (M206), in pulses of its counter.
struct Zero {
  double offset_unit = 0;
  double pulses_per_unit = 1;
};

std::optional<Seen> TouchFinely(const SwitchSeek& seek,
                                double pulses_per_unit,
                                MotorDoing* doing) {
  const int touches = doing->options().touches;
  const auto looks = LookFinely(seek, touches, pulses_per_unit, doing);
  if (!looks) return std::nullopt;
  return Seen{.pulses = looks->mean_pulses(),
              .sd_unit = looks->mean_sd_unit(),
              .budget = looks->Budget()};
}

// The published second approach, at part of the speed.
std::optional<Seen> SecondTouch(std::size_t axis,
                                double slow_unit_s,
                                MotorDoing* doing) {
  MotorAxes& axes = doing->axes();
  const MotorOptions& o = doing->options();
  const double back_unit = o.back_off_unit.value_or(kUsualBackOff_unit);
  const double speed_unit_s = o.second * slow_unit_s;
  if (!doing->Did(axes.MoveBy(axis, back_unit, slow_unit_s))) return std::nullopt;
  const auto pressed = doing->Got(axes.IsPressed(axis, /*is_min=*/true));
  if (!pressed) return std::nullopt;
  if (*pressed) {
    doing->Fail({.reply = fmt::format("a back-off of {:g} {} does not open the MIN "
                                      "switch of {}: choose a larger one",
                                      back_unit,
                                      axes.drawing(axis).unit(),
                                      MotorAxisName(axis))});
    return std::nullopt;
  }
  const bool is_done =
      doing->Did(axes.SeekSwitch(axis, -2 * back_unit, speed_unit_s)) &&
      doing->Did(axes.WaitComplete());
  const auto count = is_done ? doing->Got(axes.Count(axis)) : std::nullopt;
  if (!count) return std::nullopt;
  return Seen{.pulses = static_cast<double>(*count),
              .sd_unit = SwitchSigma(axes.bench(), axis, speed_unit_s)};
}

// Of an axis that was homed before. A rotor that was let go is caught whole magnetic
// cycles away: less than half of one is its home's or its switch's doing.
void TellLostSteps(std::size_t axis,
                   const Seen& seen,
                   const Zero& zero,
                   MotorDoing* doing) {
  const MotorAxisDrawing& d = doing->axes().drawing(axis);
  const std::string name = MotorAxisName(axis);
  const double off_unit = seen.pulses / zero.pulses_per_unit + zero.offset_unit;
  const double cycle_unit = kFullSteps * d.lead_unit / d.full_steps_per_rev;
  const double cycles = std::round(off_unit / cycle_unit);
  const double rest_unit = off_unit - cycles * cycle_unit;
  const double clear_unit = kLostSigmas * std::sqrt(2.0) * seen.sd_unit;
  if (clear_unit > cycle_unit / 2) {
    doing->Warn(fmt::format(
        "{}: the switch scatters too much ({:.1f} {}) to tell a lost magnetic cycle "
        "({:g} {})",
        name,
        UmFromMm(seen.sd_unit),
        d.fine_unit(),
        cycle_unit,
        d.unit()));
  }
  const bool has_lost = cycles != 0 && std::abs(off_unit) > clear_unit;
  doing->done().found.lost_unit = has_lost ? off_unit : 0;
  if (has_lost) {
    doing->Log(
        axis,
        fmt::format("{} had lost {:.3f} {}, {:+.0f} magnetic cycles of four full "
                    "steps",
                    name,
                    off_unit,
                    d.unit(),
                    cycles));
  } else {
    doing->Say(
        fmt::format("{} had lost no steps: {:+.1f} {} from its home, a magnetic "
                    "cycle is {:g}",
                    name,
                    UmFromMm(off_unit),
                    d.fine_unit(),
                    UmFromMm(cycle_unit)));
  }
  if (std::abs(rest_unit) > clear_unit) {
    doing->Warn(
        fmt::format("{}: {:+.1f} {} of that are no whole cycle: was it homed "
                    "as published, or has its switch moved?",
                    name,
                    UmFromMm(rest_unit),
                    d.fine_unit()));
  }
}

// The MIN switch as the procedure sees it, at that speed.
std::optional<Seen> SeeSwitch(std::size_t axis,
                              double speed_unit_s,
                              double pulses_per_unit,
                              MotorDoing* doing) {
  const MotorOptions& o = doing->options();
  if (!FindMinSwitch(axis, speed_unit_s, doing)) return std::nullopt;
  auto seen = SecondTouch(axis, speed_unit_s, doing);
  if (!seen || o.is_as_published) return seen;
  return TouchFinely({.axis = axis,
                      .sense = -1,
                      .came_unit_s = o.second * speed_unit_s,
                      .fine_unit_s = o.fine_unit_s},
                     pulses_per_unit,
                     doing);
}

// Zero, the rest from it, and what is told of both.
void KeepStepperHome(const Seen& seen,
                     const Zero& before,
                     double slow_unit_s,
                     MotorDoing* doing) {
  MotorAxes& axes = doing->axes();
  const MotorOptions& o = doing->options();
  const std::size_t axis = o.axes.front();
  const MotorAxisDrawing& d = axes.drawing(axis);
  const double zero = seen.pulses + o.final_back_off_unit * before.pulses_per_unit;
  // A record that has never seen a home has no limits from it.
  const double farther_unit =
      before.offset_unit == 0 ? 0 : o.final_back_off_unit - before.offset_unit;
  const bool is_kept =
      doing->Did(axes.SetZero(axis, std::llround(zero))) &&
      doing->Did(axes.MoveTo(axis, 0, slow_unit_s)) &&
      doing->Did(axes.MoveTo(axis, o.safe_unit - o.final_back_off_unit, slow_unit_s)) &&
      doing->Did(axes.SetField(206, axis, o.final_back_off_unit)) &&
      ShiftLimits(axis, farther_unit, doing) && doing->Store(axis);
  if (!is_kept) return;
  const std::string name = "home_offset." + MotorAxisName(axis);
  doing->Step({.quantity = name,
               .unit = d.unit(),
               .after = o.final_back_off_unit,
               .verdict = Verdict::kApplied,
               .message = fmt::format("zero stands {:g} {} from the switch, told to "
                                      "{:.1f} {}",
                                      o.final_back_off_unit,
                                      d.unit(),
                                      UmFromMm(seen.sd_unit),
                                      d.fine_unit())});
  if (o.is_as_published) {
    // The text states no uncertainty.
    doing->Found({.name = name,
                  .unit = d.unit(),
                  .value = o.final_back_off_unit,
                  .identifiable = true});
    return;
  }
  const auto gap_unit = CompensatedGap(axis, "home_offset", doing);
  if (!gap_unit) return;
  doing->Found(
      name, d.unit(), OfCarriage(o.final_back_off_unit, *gap_unit, seen.budget));
}

}  // namespace

MotorResult RunStepperHome(MotorAxes* axes, const MotorOptions& options) {
  MotorDoing doing("stepper_home", options, axes);
  const std::size_t axis = options.axes.front();
  const auto pulses = doing.Got(axes->Field(92, axis));
  const auto says = doing.Got(axes->Drive(axis));
  const auto per_rev = doing.Got(axes->Field(812, axis));
  const auto top_unit_s = doing.TopSpeed_unit_s(axis);
  if (!pulses || !says || !per_rev || !top_unit_s) return doing.Take();
  const auto usual_unit_s2 = doing.Got(axes->Field(201, axis));
  const auto stored_unit = doing.Got(axes->Field(206, axis));
  const double slow_unit_s = options.slow * *top_unit_s;
  const bool may_begin =
      usual_unit_s2 && stored_unit && MayHomeAtScale(axis, *pulses, *per_rev, &doing) &&
      (options.is_as_published || doing.SetForNow(425, axis, 0)) &&
      doing.SetForNow(201, axis, kGentle * *usual_unit_s2) &&
      StopsBehindASwitch(axis, slow_unit_s, &doing) &&
      (options.is_as_published ||
       StopsBehindASwitch(axis, options.fine_unit_s, &doing, "fine")) &&
      doing.Did(axes->ForgetHome(axis));
  if (!may_begin) return doing.Take();
  const auto seen = doing.TrySlower(slow_unit_s, [&](double speed_unit_s) {
    return SeeSwitch(axis, speed_unit_s, *pulses, &doing);
  });
  if (!doing.PutBack() || !seen) return doing.Take();
  const Zero before{.offset_unit = *stored_unit, .pulses_per_unit = *pulses};
  if (says->was_homed) TellLostSteps(axis, *seen, before, &doing);
  KeepStepperHome(*seen, before, slow_unit_s, &doing);
  return doing.Take();
}

}  // namespace caltwin
