#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "calibration/kinds/motor_stage/switch_looks.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kUsualBackOffOf = 2;
constexpr double kTwoSided = 4;  // |offset| beyond a turn's 1/4: not this switch.

/// What one homing has in hand; counts from the axis' old zero.
struct Homing {
  std::size_t axis = 0;
  double pulses_per_unit = 1;
  double lead_unit = 1;
  double slow_unit_s = 1;
  SwitchSeek seek{};
  SwitchLooks looks{};         ///< At the switch; as published one.
  std::int64_t at_switch = 0;  ///< Their mean.
  std::int64_t backed_off = 0;
  std::int64_t index = 0;

  double after_back_off_unit() const {
    return static_cast<double>(index - backed_off) / pulses_per_unit;
  }
  double offset_unit() const {
    return static_cast<double>(index - at_switch) / pulses_per_unit;
  }
};

// Without memory some index place must divide those that are home from those whose next
// one is. As published it is where the back-off ends; here a quarter turn beyond that.
constexpr double kCut_turns = 0.25;
constexpr int kMostLooks = 25;

double Below(double sigmas) {
  return std::erfc(sigmas / std::sqrt(2.0)) / 2;
}

// The share of homings, each with one look, whose back-off ends on the other side of an
// index, if that stood so much farther.
double WrongTurns(const Homing& homing, double farther_unit = 0) {
  const double to_unit = homing.after_back_off_unit() + farther_unit;
  const double sigma_unit = homing.looks.sigma_unit;
  return Below(to_unit / sigma_unit) + Below((homing.lead_unit - to_unit) / sigma_unit);
}

double BackOffOf(const MotorDoing& doing) {
  return doing.options().back_off_unit.value_or(kUsualBackOffOf);
}

bool HuntIndex(Homing* homing, MotorDoing* doing) {
  const auto index =
      FindIndex(homing->axis, homing->lead_unit, homing->slow_unit_s, doing);
  if (index) homing->index = *index;
  return index.has_value();
}

// How far an index stands beyond the cut, by the switch; below 0: its next one is home.
double BeyondCut(const Homing& homing, const MotorDoing& doing) {
  return homing.offset_unit() - BackOffOf(doing) - kCut_turns * homing.lead_unit;
}

// Looks at the switch until their mean says clearly on which side of the cut the index
// is: n looks scatter sqrt(n) less than one.
bool LookUntilClear(Homing* homing, MotorDoing* doing) {
  const auto most =
      static_cast<std::size_t>(std::max(kMostLooks, doing->options().touches));
  SwitchLooks& looks = homing->looks;
  const auto is_clear = [&] {
    return std::abs(BeyondCut(*homing, *doing)) >=
           doing->options().reach_sigmas * looks.mean_sd_unit();
  };
  if (is_clear()) return true;
  // From where the index was found: as if it had come from there to the switch.
  const auto now = doing->Got(doing->axes().Count(homing->axis));
  if (!now) return false;
  const double above_unit =
      static_cast<double>(*now - homing->at_switch) / homing->pulses_per_unit;
  if (!doing->Did(
          doing->axes().MoveBy(homing->axis, -above_unit, homing->slow_unit_s))) {
    return false;
  }
  while (looks.at_pulses.size() < most && !is_clear()) {
    if (!LookAtSwitch(homing->seek, homing->pulses_per_unit, &looks, doing)) {
      return false;
    }
    homing->at_switch = std::llround(looks.mean_pulses());
  }
  doing->Say(
      fmt::format("the switch of {} was looked at {} times: the index is near "
                  "where its turn is decided",
                  MotorAxisName(homing->axis),
                  looks.at_pulses.size()));
  if (is_clear()) return true;
  const double share =
      Below(std::abs(BeyondCut(*homing, *doing)) / looks.mean_sd_unit());
  doing->Warn(fmt::format(
      "{:.2g} % of first homings of {} would be a turn off, {} looks do not tell which "
      "index is home: move its switch's flag by a quarter of a turn ({:g} {})",
      PercentFromFraction(share),
      MotorAxisName(homing->axis),
      looks.at_pulses.size(),
      kCut_turns * homing->lead_unit,
      doing->axes().drawing(homing->axis).unit()));
  return true;
}

// Half a turn between the back-off's end and the index.
bool BackOffFarther(Homing* homing, MotorDoing* doing) {
  MotorAxes& axes = doing->axes();
  const double to_unit = homing->after_back_off_unit();
  const double half_unit = homing->lead_unit / 2;
  const double more_unit =
      to_unit < half_unit ? to_unit + half_unit : to_unit - half_unit;
  const auto now = doing->Got(axes.Count(homing->axis));
  if (!now) return false;
  homing->backed_off += std::llround(more_unit * homing->pulses_per_unit);
  const double by_unit =
      static_cast<double>(homing->backed_off - *now) / homing->pulses_per_unit;
  if (!doing->Did(axes.MoveBy(homing->axis, by_unit, homing->slow_unit_s)))
    return false;
  if (!HuntIndex(homing, doing)) return false;
  doing->Say(
      fmt::format("backed off by {:.3f} {} more: the index is half a turn from "
                  "there, out of the switch's reach",
                  more_unit,
                  axes.drawing(homing->axis).unit()));
  return true;
}

// How near the index is is known as well as the looks at the switch are: the share
// holds between what it would be two standard deviations nearer and farther.
void WarnOfReach(const Homing& homing, MotorDoing* doing) {
  const double to_unit = homing.after_back_off_unit();
  const double near_unit = std::min(to_unit, homing.lead_unit - to_unit);
  const double sigma_unit = homing.looks.sigma_unit;
  const double away = to_unit < homing.lead_unit / 2 ? 2 : -2;
  const double by_unit = away * homing.looks.mean_sd_unit();
  const MotorAxisDrawing& d = doing->axes().drawing(homing.axis);
  doing->Warn(
      fmt::format("the back-off of {} ends {:.1f} {} from an index, {:.1f} times the "
                  "switch's scatter ({:.1f} {}): {:.2g} % ({:.2g} to {:.2g}) of "
                  "homings with one look would be a turn ({:g} {}) off",
                  MotorAxisName(homing.axis),
                  UmFromMm(near_unit),
                  d.fine_unit(),
                  near_unit / sigma_unit,
                  UmFromMm(sigma_unit),
                  d.fine_unit(),
                  PercentFromFraction(WrongTurns(homing)),
                  PercentFromFraction(WrongTurns(homing, by_unit)),
                  PercentFromFraction(WrongTurns(homing, -by_unit)),
                  homing.lead_unit,
                  d.unit()));
}

// Against the offset that was stored: whole turns are the switch's, the rest is none.
bool CountTurns(double stored_unit, Homing* homing, MotorDoing* doing) {
  const double off_unit = homing->offset_unit() - stored_unit;
  const double turns = std::round(off_unit / homing->lead_unit);
  const double rest_unit = off_unit - turns * homing->lead_unit;
  if (std::abs(rest_unit) > homing->lead_unit / kTwoSided) {
    doing->Meet({.kind = MotorCondition::Kind::kMismatch,
                 .axis = homing->axis,
                 .words = fmt::format(
                     "the index of {} stands {:+.3f} {} from where it was over "
                     "the switch",
                     MotorAxisName(homing->axis),
                     rest_unit,
                     doing->axes().drawing(homing->axis).unit()),
                 .remedy = "has a switch or a coupling moved?"});
    return false;
  }
  // A switch's scatter turns home by one at most.
  if (std::abs(turns) > 1) {
    doing->Meet(
        {.kind = MotorCondition::Kind::kMismatch,
         .axis = homing->axis,
         .words = fmt::format("the index of {} is {:+g} turns from where it was "
                              "over the switch (M206, {:.3f} {})",
                              MotorAxisName(homing->axis),
                              turns,
                              stored_unit,
                              doing->axes().drawing(homing->axis).unit()),
         .remedy = "is that another machine's record, or was the switch moved? "
                   "M206 0 homes it as at first"});
    return false;
  }
  const double pulses = turns * homing->lead_unit * homing->pulses_per_unit;
  homing->index -= std::llround(pulses);
  if (turns != 0) {
    doing->Say(fmt::format(
        "{:+g} turn of the motor against the stored home: taken back", turns));
  }
  return true;
}

// To the switch at that speed, corrected to the mean of several looks; and back off.
bool ToSwitch(double speed_unit_s, Homing* homing, MotorDoing* doing) {
  MotorAxes& axes = doing->axes();
  const std::size_t axis = homing->axis;
  homing->slow_unit_s = speed_unit_s;
  if (!FindMinSwitch(axis, speed_unit_s, doing)) return false;
  if (!doing->Did(axes.WaitComplete())) return false;
  auto stands = doing->Got(axes.Count(axis));
  if (!stands) return false;
  homing->looks = {.at_pulses = {static_cast<double>(*stands)},
                   .sigma_unit = SwitchSigma(axes.bench(), axis, speed_unit_s)};
  if (!doing->options().is_as_published) {
    homing->seek = {.axis = axis,
                    .sense = -1,
                    .came_unit_s = speed_unit_s,
                    .fine_unit_s = kSecondLook * speed_unit_s};
    auto looks = LookFinely(
        homing->seek, doing->options().touches, homing->pulses_per_unit, doing);
    if (!looks) return false;
    homing->looks = *std::move(looks);
    stands = doing->Got(axes.Count(axis));
    if (!stands) return false;
  }
  homing->at_switch = std::llround(homing->looks.mean_pulses());
  const double beyond_unit =
      static_cast<double>(*stands - homing->at_switch) / homing->pulses_per_unit;
  const double back_unit = BackOffOf(*doing) - beyond_unit;
  if (!doing->Did(axes.MoveBy(axis, back_unit, speed_unit_s))) return false;
  const auto backed_off = doing->Got(axes.Count(axis));
  if (backed_off) homing->backed_off = *backed_off;
  return backed_off.has_value();
}

bool Correct(double stored_unit, Homing* homing, MotorDoing* doing) {
  const double to_unit = homing->after_back_off_unit();
  const double near_unit = std::min(to_unit, homing->lead_unit - to_unit);
  const bool is_near =
      near_unit < doing->options().reach_sigmas * homing->looks.sigma_unit;
  if (is_near) WarnOfReach(*homing, doing);
  if (stored_unit != 0) return CountTurns(stored_unit, homing, doing);
  if (!LookUntilClear(homing, doing)) return false;
  const bool is_next = BeyondCut(*homing, *doing) < 0;
  return !(is_near || is_next) || BackOffFarther(homing, doing);
}

}  // namespace

namespace {

// Limits were measured from the zero of before; where nobody knows that any more they
// are the factory's again.
bool KeepLimits(double stored_unit,
                double offset_unit,
                const Homing& homing,
                MotorDoing* doing) {
  MotorAxes& axes = doing->axes();
  if (stored_unit != 0) {
    // To a turn: the rest is what the looks at the switch scatter by.
    const double turns = std::round((offset_unit - stored_unit) / homing.lead_unit);
    return ShiftLimits(homing.axis, turns * homing.lead_unit, doing);
  }
  const MotorAxisDrawing& d = axes.drawing(homing.axis);
  const auto high_unit = doing->Got(axes.Field(208, homing.axis));
  if (!high_unit) return false;
  if (std::abs(*high_unit - d.max_unit) < 1e-3) return true;
  doing->Warn(
      fmt::format("the limits of {} were measured from a zero that M206 does not "
                  "tell any more: those drawn hold, run travel_limits again",
                  MotorAxisName(homing.axis)));
  return doing->Did(axes.SetLimits(homing.axis, d.min_unit, d.max_unit));
}

// Zero, what it is called and how sure that is.
void KeepHome(double stored_unit, const Homing& homing, MotorDoing* doing) {
  MotorAxes& axes = doing->axes();
  const std::size_t axis = homing.axis;
  const bool is_as_published = doing->options().is_as_published;
  const auto stands = doing->Got(axes.Count(axis));
  if (!stands) return;
  const std::int64_t zero = is_as_published ? *stands : homing.index;
  const double offset_unit =
      static_cast<double>(zero - homing.at_switch) / homing.pulses_per_unit;
  const bool is_kept =
      doing->Did(axes.SetZero(axis, zero)) &&
      doing->Did(axes.SetField(206, axis, offset_unit)) &&
      (is_as_published || KeepLimits(stored_unit, offset_unit, homing, doing)) &&
      doing->Store(axis);
  if (!is_kept) return;
  const std::string name = "home_offset." + MotorAxisName(axis);
  const std::string unit = axes.drawing(axis).unit();
  doing->Step({.quantity = name,
               .unit = unit,
               .before = stored_unit,
               .after = offset_unit,
               .verdict = Verdict::kApplied,
               .message = is_as_published
                              ? "zero is where the axis stood after the index"
                              : "zero is the index itself, as latched"});
  if (is_as_published) {
    // The text states no uncertainty.
    doing->Found(
        {.name = name, .unit = unit, .value = offset_unit, .identifiable = true});
    return;
  }
  const auto gap_unit = CompensatedGap(axis, "home_offset", doing);
  if (!gap_unit) return;
  doing->Found(name, unit, OfCarriage(offset_unit, *gap_unit, homing.looks.Budget()));
}

}  // namespace

MotorResult RunServoHome(MotorAxes* axes, const MotorOptions& options) {
  MotorDoing doing("servo_home", options, axes);
  Homing homing{.axis = options.axes.front()};
  const std::size_t axis = homing.axis;
  const auto pulses = doing.Got(axes->Field(92, axis));
  const auto stored_unit = doing.Got(axes->Field(206, axis));
  const auto per_rev = doing.Got(axes->Field(812, axis));
  const auto top_unit_s = doing.TopSpeed_unit_s(axis);
  if (!pulses || !stored_unit || !per_rev || !top_unit_s) return doing.Take();
  homing.pulses_per_unit = *pulses;
  homing.lead_unit = *per_rev / *pulses;
  if (!MayHomeAtScale(axis, *pulses, *per_rev, &doing)) return doing.Take();
  const double slow_unit_s = options.slow * *top_unit_s;
  if (!StopsBehindASwitch(axis, slow_unit_s, &doing)) return doing.Take();
  // A compensation would drive a back-off on by as much, past an index perhaps.
  const bool may_begin = options.is_as_published ||
                         (doing.SetForNow(425, axis, 0) && doing.WithoutDelay(axis));
  if (!may_begin || !doing.Did(axes->ForgetHome(axis))) return doing.Take();
  const bool is_there = doing.TrySlower(slow_unit_s, [&](double speed_unit_s) {
    return ToSwitch(speed_unit_s, &homing, &doing);
  }) && HuntIndex(&homing, &doing);
  if (!is_there) return doing.Take();
  doing.done().found.wrong_turn_probability = WrongTurns(homing);
  if (!options.is_as_published && !Correct(*stored_unit, &homing, &doing)) {
    return doing.Take();
  }
  KeepHome(*stored_unit, homing, &doing);
  return doing.Take();
}

}  // namespace caltwin
