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
  double sigma_unit = 0;   ///< and how sure the place is.
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
  doing->Warn(
      fmt::format("the back-off of {} ends {:.1f} um from an index, {:.1f} times the "
                  "switch's scatter "
                  "({:.1f} um): {:.2g} % of homings would be a turn ({:g} {}) off",
                  MotorAxisName(homing.axis),
                  UmFromMm(near_unit),
                  near_unit / homing.sigma_unit,
                  UmFromMm(homing.sigma_unit),
                  PercentFromFraction(share),
                  homing.lead_unit,
                  doing->axes().drawing(homing.axis).unit()));
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
  return !is_near || BackOffFarther(homing, doing);
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
  homing.pulses_per_unit = *pulses;
  homing.lead_unit = *per_rev / *pulses;
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
      OfCarriage(
          offset_unit, *gap_unit, SwitchBudget(axes->bench(), homing.seen_unit_s)));
  return doing.Take();
}

}  // namespace caltwin
