#include <algorithm>
#include <cmath>

#include "calibration/motor_axes/doing.h"
#include "sim/base/mutant.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kUsualBackOff_unit = 2;
constexpr double kHunt = 1.2;    // Turns that are gone to look for an index.
constexpr double kTwoSided = 4;  // |offset| beyond a turn's 1/4: not this switch.

/// What one homing has in hand; counts from the axis' old zero.
struct Homing {
  std::size_t axis = 0;
  double pulses_per_unit = 1;
  double lead_unit = 1;
  double slow_unit_s = 1;
  double seen_unit_s = 0;  ///< Speed with which it was seen at the switch,
  double sigma_unit = 0;   ///< and how sure one look at it is.
  int looks = 1;           ///< Of which at_switch is the mean.
  std::int64_t at_switch = 0;
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

// The share of homings whose back-off ends on the other side of an index.
double WrongTurns(const Homing& homing) {
  const double to_unit = homing.after_back_off_unit();
  return Below(to_unit / homing.sigma_unit) +
         Below((homing.lead_unit - to_unit) / homing.sigma_unit);
}

// On to the next index; back and again at half the speed where none comes.
bool HuntIndex(Homing* homing, MotorDoing* doing) {
  MotorAxes& axes = doing->axes();
  const std::size_t axis = homing->axis;
  double speed_unit_s = homing->slow_unit_s;
  for (int attempt = 0; attempt <= doing->options().retries; ++attempt) {
    if (!doing->Did(axes.ClearDrive(axis))) return false;
    const auto found = axes.SeekIndex(axis, kHunt * homing->lead_unit, speed_unit_s);
    if (found) {
      if (!doing->Did(axes.WaitComplete())) return false;
      const auto says = doing->Got(axes.Drive(axis));
      if (!says || !says->index) return false;
      homing->index = *says->index;
      return true;
    }
    if (TroubleOf(found.error()) != MotorTrouble::kIndexMissing) {
      doing->Fail(found.error());
      return false;
    }
    doing->Log(axis,
               fmt::format("no index pulse of {} within one revolution at {:g} {}/s",
                           MotorAxisName(axis),
                           speed_unit_s,
                           axes.drawing(axis).unit()));
    if (!doing->Did(axes.MoveBy(axis, -kHunt * homing->lead_unit, speed_unit_s))) {
      return false;
    }
    if (attempt < doing->options().retries) ++doing->done().found.retries;
    speed_unit_s /= 2;
  }
  doing->Alert(axis,
               fmt::format("index of {} missing: is its wire on, is it enabled (M813)?",
                           MotorAxisName(axis)));
  doing->SafeSlow(axis);
  return false;
}

// A second look at the switch, so slow that the expander's period is little.
bool LookAgain(double back_off_unit, Homing* homing, MotorDoing* doing) {
  MotorAxes& axes = doing->axes();
  const double fine_unit_s = kSecondLook * homing->slow_unit_s;
  homing->seen_unit_s = fine_unit_s;
  homing->sigma_unit = SwitchSigma(axes.bench(), fine_unit_s);
  return doing->Did(axes.MoveBy(homing->axis, back_off_unit, homing->slow_unit_s)) &&
         doing->Did(axes.SeekSwitch(homing->axis, -2 * back_off_unit, fine_unit_s));
}

// How far an index stands beyond the cut, by the switch; below 0: its next one is home.
double BeyondCut(const Homing& homing, const MotorDoing& doing) {
  const double back_off_unit =
      doing.options().back_off_unit.value_or(kUsualBackOff_unit);
  return homing.offset_unit() - back_off_unit - kCut_turns * homing.lead_unit;
}

// One more look at the switch, as slow as the second.
std::optional<double> NextLook(double back_off_unit,
                               const Homing& homing,
                               MotorDoing* doing) {
  MotorAxes& axes = doing->axes();
  const std::size_t axis = homing.axis;
  const double fine_unit_s = homing.seen_unit_s;
  const auto now = doing->Got(axes.Count(axis));
  const auto late_unit = SeenLate(axis, fine_unit_s, doing);
  if (!now || !late_unit) return std::nullopt;
  const double above_unit =
      static_cast<double>(*now - homing.at_switch) / homing.pulses_per_unit;
  const bool is_done =
      doing->Did(axes.MoveBy(axis, back_off_unit - above_unit, homing.slow_unit_s)) &&
      doing->Did(axes.SeekSwitch(axis, -2 * back_off_unit, fine_unit_s)) &&
      doing->Did(axes.WaitComplete());
  const auto count = is_done ? doing->Got(axes.Count(axis)) : std::nullopt;
  if (!count) return std::nullopt;
  return static_cast<double>(*count) + *late_unit * homing.pulses_per_unit;
}

// Looks at the switch until their mean says clearly on which side of the cut the index
// is: n looks scatter sqrt(n) less than one.
bool LookUntilClear(Homing* homing, MotorDoing* doing) {
  const MotorOptions& o = doing->options();
  const double back_off_unit = o.back_off_unit.value_or(kUsualBackOff_unit);
  double sum_pulses = static_cast<double>(homing->at_switch);
  const int most = Mutant("home_looks_once", kMostLooks, 1);
  const auto is_clear = [&] {
    return std::abs(BeyondCut(*homing, *doing)) >=
           o.reach_sigmas * homing->sigma_unit / std::sqrt(homing->looks);
  };
  while (homing->looks < most && !is_clear()) {
    const auto seen_pulses = NextLook(back_off_unit, *homing, doing);
    if (!seen_pulses) return false;
    sum_pulses += *seen_pulses;
    ++homing->looks;
    homing->at_switch = std::llround(sum_pulses / homing->looks);
  }
  if (homing->looks > 1) {
    doing->Say(
        fmt::format("the switch of {} was looked at {} times: the index is near "
                    "where its turn is decided",
                    MotorAxisName(homing->axis),
                    homing->looks));
  }
  if (is_clear()) return true;
  const double sigma_unit = homing->sigma_unit / std::sqrt(homing->looks);
  doing->Warn(fmt::format(
      "{:.2g} % of first homings of {} would be a turn off, {} looks do not tell which "
      "index is home: move its switch's flag by a quarter of a turn ({:g} {})",
      PercentFromFraction(Below(std::abs(BeyondCut(*homing, *doing)) / sigma_unit)),
      MotorAxisName(homing->axis),
      homing->looks,
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

void WarnOfReach(const Homing& homing, MotorDoing* doing) {
  const double to_unit = homing.after_back_off_unit();
  const double near_unit = std::min(to_unit, homing.lead_unit - to_unit);
  const double share = WrongTurns(homing);
  const MotorAxisDrawing& d = doing->axes().drawing(homing.axis);
  doing->Warn(
      fmt::format("the back-off of {} ends {:.1f} {} from an index, {:.1f} times the "
                  "switch's scatter ({:.1f} {}): {:.2g} % of homings would be a turn "
                  "({:g} {}) off",
                  MotorAxisName(homing.axis),
                  UmFromMm(near_unit),
                  d.fine_unit(),
                  near_unit / homing.sigma_unit,
                  UmFromMm(homing.sigma_unit),
                  d.fine_unit(),
                  PercentFromFraction(share),
                  homing.lead_unit,
                  d.unit()));
}

// Against the offset that was stored: whole turns are the switch's, the rest is none.
bool CountTurns(double stored_unit, Homing* homing, MotorDoing* doing) {
  const double off_unit = homing->offset_unit() - stored_unit;
  const double turns = std::round(off_unit / homing->lead_unit);
  const double rest_unit = off_unit - turns * homing->lead_unit;
  if (std::abs(rest_unit) > homing->lead_unit / kTwoSided) {
    doing->Alert(homing->axis,
                 fmt::format("the index of {} stands {:+.3f} {} from where it was over "
                             "the switch: has a switch or a coupling moved?",
                             MotorAxisName(homing->axis),
                             rest_unit,
                             doing->axes().drawing(homing->axis).unit()));
    return false;
  }
  const double pulses = turns * homing->lead_unit * homing->pulses_per_unit;
  homing->index -= Mutant("home_ignores_turns", std::llround(pulses), 0LL);
  if (turns != 0) {
    doing->Say(fmt::format(
        "{:+g} turn of the motor against the stored home: taken back", turns));
  }
  return true;
}

bool ToSwitch(Homing* homing, MotorDoing* doing) {
  MotorAxes& axes = doing->axes();
  const std::size_t axis = homing->axis;
  const double back_off_unit =
      doing->options().back_off_unit.value_or(kUsualBackOff_unit);
  const auto speed_unit_s = FindMinSwitch(axis, doing);
  if (!speed_unit_s) return false;
  homing->slow_unit_s = *speed_unit_s;
  homing->seen_unit_s = *speed_unit_s;
  homing->sigma_unit = SwitchSigma(axes.bench(), *speed_unit_s);
  if (!doing->options().is_as_published && !LookAgain(back_off_unit, homing, doing)) {
    return false;
  }
  if (!doing->Did(axes.WaitComplete())) return false;
  const auto at_switch = doing->Got(axes.Count(axis));
  if (!at_switch) return false;
  if (!doing->Did(axes.MoveBy(axis, back_off_unit, homing->slow_unit_s))) return false;
  const auto backed_off = doing->Got(axes.Count(axis));
  if (!backed_off) return false;
  homing->at_switch = *at_switch;
  if (!doing->options().is_as_published) {
    const auto late_unit = SeenLate(axis, kSecondLook * *speed_unit_s, doing);
    if (!late_unit) return false;
    homing->at_switch += std::llround(*late_unit * homing->pulses_per_unit);
  }
  homing->backed_off = *backed_off;
  return true;
}

bool Correct(double stored_unit, Homing* homing, MotorDoing* doing) {
  const double to_unit = homing->after_back_off_unit();
  const double near_unit = std::min(to_unit, homing->lead_unit - to_unit);
  const bool is_near = near_unit < doing->options().reach_sigmas * homing->sigma_unit;
  if (is_near) WarnOfReach(*homing, doing);
  if (stored_unit != 0) return CountTurns(stored_unit, homing, doing);
  if (!LookUntilClear(homing, doing)) return false;
  const double reach_unit = doing->options().reach_sigmas * homing->sigma_unit;
  const bool is_next = Mutant(
      "home_cut_within_reach", BeyondCut(*homing, *doing) < 0, near_unit < reach_unit);
  return !(is_near || is_next) || BackOffFarther(homing, doing);
}

}  // namespace

MotorResult RunServoHome(MotorAxes* axes, const MotorOptions& options) {
  MotorDoing doing("servo_home", options, axes);
  Homing homing{.axis = options.axes.front()};
  const std::size_t axis = homing.axis;
  const auto pulses = doing.Got(axes->Field(92, axis));
  const auto stored_unit = doing.Got(axes->Field(206, axis));
  const auto per_rev = doing.Got(axes->Field(812, axis));
  if (!pulses || !stored_unit || !per_rev) return doing.Take();
  if (!doing.Did(axes->ForgetHome(axis))) return doing.Take();
  homing.pulses_per_unit = *pulses;
  homing.lead_unit = *per_rev / *pulses;
  HintAtScale(axis, *pulses, *per_rev, &doing);
  if (!ToSwitch(&homing, &doing) || !HuntIndex(&homing, &doing)) return doing.Take();
  doing.done().found.wrong_turn_probability = WrongTurns(homing);
  const auto stands = doing.Got(axes->Count(axis));
  if (!stands) return doing.Take();
  if (!options.is_as_published && !Correct(*stored_unit, &homing, &doing)) {
    return doing.Take();
  }
  const std::int64_t latched =
      Mutant("home_where_it_stopped", homing.index, homing.index + 40);
  const std::int64_t zero = options.is_as_published ? *stands : latched;
  const double offset_unit = static_cast<double>(zero - homing.at_switch) / *pulses;
  const bool is_kept = doing.Did(axes->SetZero(axis, zero)) &&
                       doing.Did(axes->SetField(206, axis, offset_unit)) &&
                       doing.Did(axes->Store(axis));
  if (!is_kept) return doing.Take();
  const std::string name = "home_offset." + MotorAxisName(axis);
  doing.Step(name,
             *stored_unit,
             offset_unit,
             Verdict::kApplied,
             options.is_as_published ? "zero is where the axis stood after the index"
                                     : "zero is the index itself, as latched");
  const auto gap_unit = CompensatedGap(axis, "home_offset", &doing);
  if (!gap_unit) return doing.Take();
  doing.Found(
      name,
      axes->drawing(axis).unit(),
      OfCarriage(offset_unit,
                 *gap_unit,
                 SwitchBudget(axes->bench(), homing.seen_unit_s, homing.looks)));
  return doing.Take();
}

}  // namespace caltwin
