#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include <fmt/format.h>

#include "calibration/estimate/expanded.h"
#include "calibration/kinds/motor_stage/doing.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

using Moments = std::map<std::size_t, double>;  // When each servo was half way [s].

// Homes what is not homed yet, one after the other.
bool HomeAll(MotorDoing* doing) {
  MotorAxes& axes = doing->axes();
  for (const std::size_t axis : doing->options().axes) {
    const auto says = doing->Got(axes.Drive(axis));
    if (!says) return false;
    if (says->is_homed) continue;
    MotorOptions home = doing->options();
    home.axes = {axis};
    home.is_as_published = false;
    if (!axes.drawing(axis).is_servo && !KeepHomeOffset(axis, &home, doing)) {
      return false;
    }
    const bool is_homed =
        doing->Absorb(axes.drawing(axis).is_servo ? RunServoHome(&axes, home)
                                                  : RunStepperHome(&axes, home));
    if (!is_homed) return false;
  }
  return true;
}

bool GoToMiddle(MotorDoing* doing) {
  MotorAxes& axes = doing->axes();
  return std::ranges::all_of(doing->options().axes, [&](std::size_t axis) {
    const MotorAxisDrawing& d = axes.drawing(axis);
    const double middle_unit = (d.min_unit + d.max_unit) / 2;
    return doing->Did(axes.MoveTo(axis, middle_unit, d.max_velocity_unit_s / 2));
  });
}

// From the middle and back, all together, several times.
std::optional<Moments> MoveAndTime(double speed_unit_s, MotorDoing* doing) {
  MotorAxes& axes = doing->axes();
  const MotorOptions& o = doing->options();
  if (!GoToMiddle(doing)) return std::nullopt;
  Moments moments;
  for (int i = 0; i < o.repeats; ++i) {
    if (!doing->Did(axes.MoveTogether(o.axes, o.distance_unit, speed_unit_s)) ||
        !doing->Did(axes.WaitComplete())) {
      return std::nullopt;
    }
    for (const std::size_t axis : o.axes) {
      const auto says = doing->Got(axes.Drive(axis));
      if (!says) return std::nullopt;
      if (!axes.drawing(axis).is_servo) continue;
      if (!says->half_way_s) {
        doing->Fail({.reply = "the controller did not see " + MotorAxisName(axis) +
                              " pass the middle of its move"});
        return std::nullopt;
      }
      moments[axis] += *says->half_way_s / o.repeats;
    }
    if (!doing->Did(axes.MoveTogether(o.axes, -o.distance_unit, speed_unit_s)) ||
        !doing->Did(axes.WaitComplete())) {
      return std::nullopt;
    }
  }
  return moments;
}

// Of the mean moment at which a counter is half way. A counter shows whole pulses:
// where it set out from (1/12), and at the two ticks between which it is interpolated
// (1/12 each, together 2/3 of it in the mean over where between them half the way
// lies).
double HalfWaySd_s(std::size_t axis, double speed_unit_s, const MotorDoing& doing) {
  const double pulse_s =
      1 / doing.axes().drawing(axis).pulses_per_unit() / speed_unit_s;
  return pulse_s * std::sqrt((1 + 2.0 / 3) / 12 / doing.options().repeats);
}

// How fast the axes are half way: a short move is over before it gets to its speed.
std::optional<double> HalfWaySpeed_unit_s(double speed_unit_s, MotorDoing* doing) {
  double least_unit_s2 = std::numeric_limits<double>::max();
  for (const std::size_t axis : doing->options().axes) {
    const auto in_force = doing->Got(doing->axes().Field(201, axis));
    if (!in_force) return std::nullopt;
    least_unit_s2 = std::min(least_unit_s2, *in_force);
  }
  const double most_unit_s = std::sqrt(least_unit_s2 * doing->options().distance_unit);
  return std::min(speed_unit_s, most_unit_s);
}

double Latest(const Moments& moments) {
  double latest_s = 0;
  for (const auto& [axis, at_s] : moments) latest_s = std::max(latest_s, at_s);
  return latest_s;
}

// How much earlier an axis is than the latest: of that one nothing, exactly.
Uncertain LeadOf(std::size_t axis,
                 const Moments& moments,
                 double speed_unit_s,
                 const MotorDoing& doing) {
  const double latest_s = Latest(moments);
  const auto latest =
      std::ranges::find(moments, latest_s, &Moments::value_type::second);
  if (axis == latest->first) return {.identifiable = true};
  return WithBudget(
      latest_s - moments.at(axis),
      {{.input = "its own counter", .u = HalfWaySd_s(axis, speed_unit_s, doing)},
       {.input = "the latest axis' counter",
        .u = HalfWaySd_s(latest->first, speed_unit_s, doing)}});
}

double Skew_s(const Moments& moments) {
  double earliest_s = Latest(moments);
  for (const auto& [axis, at_s] : moments) earliest_s = std::min(earliest_s, at_s);
  return Latest(moments) - earliest_s;
}

void SayOpenLoop(MotorDoing* doing) {
  for (const std::size_t axis : doing->options().axes) {
    if (doing->axes().drawing(axis).is_servo) continue;
    const std::string name = MotorAxisName(axis);
    doing->done().result.observability.push_back(
        {fmt::format(
             "{} is open-loop: its controller knows when it sent pulses, not when "
             "the axis moved",
             name),
         {{"start_delay." + name, 1.0}}});
  }
}

using Delays = std::map<std::size_t, double>;  // Of each servo, as M816 has it [s].

std::optional<Delays> DelaysInForce(MotorDoing* doing) {
  Delays delays;
  for (const std::size_t axis : doing->options().axes) {
    if (!doing->axes().drawing(axis).is_servo) continue;
    const auto delay_s = doing->Got(doing->axes().Delay_s(axis));
    if (!delay_s) return std::nullopt;
    delays[axis] = *delay_s;
  }
  return delays;
}

bool SetDelays(const Delays& delays, MotorDoing* doing) {
  return std::ranges::all_of(delays, [&](const auto& delay) {
    return doing->Did(doing->axes().SetDelay_s(delay.first, delay.second));
  });
}

// Those in force and how much earlier each axis is, the least of them 0.
Delays Aligned(const Delays& in_force, const Moments& moments) {
  Delays delays;
  double least_s = std::numeric_limits<double>::max();
  for (const auto& [axis, delay_s] : in_force) {
    const double early_s = Latest(moments) - moments.at(axis);
    delays[axis] = delay_s + early_s;
    least_s = std::min(least_s, delays[axis]);
  }
  for (auto& [axis, delay_s] : delays) delay_s -= least_s;
  return delays;
}

void TellLeads(const Moments& moments, double speed_unit_s, MotorDoing* doing) {
  for (const auto& [axis, at_s] : moments) {
    const double early_s = Latest(moments) - at_s;
    const std::string name = "start_lead." + MotorAxisName(axis);
    // The text measures, and estimates nothing.
    if (!doing->options().is_as_published) {
      doing->Found(name, "s", LeadOf(axis, moments, speed_unit_s, *doing));
    }
    doing->Step({.quantity = name,
                 .unit = "s",
                 .after = early_s,
                 .verdict = Verdict::kMeasured,
                 .message = fmt::format(
                     "{:.3f} ms before the latest axis: {:.1f} um off the "
                     "path at {:g} {}/s; a delay of as much (M816) aligns it",
                     early_s / SFromMs(1.0),
                     UmFromMm(early_s * speed_unit_s),
                     speed_unit_s,
                     doing->axes().drawing(axis).unit())});
  }
}

// How far the skew may be off: the two axes that are farthest apart.
double SkewSd_s(const Moments& moments, double speed_unit_s, const MotorDoing& doing) {
  double worst_s = 0;
  for (const auto& [axis, at_s] : moments) {
    worst_s = std::max(worst_s, HalfWaySd_s(axis, speed_unit_s, doing));
  }
  return std::sqrt(2.0) * worst_s;
}

struct MoveSpeed {
  double asked_unit_s = 0, half_way_unit_s = 0;
};

// Sets the delays, tries them, and takes them back where the axes are farther apart.
void Align(const Moments& before, const MoveSpeed& speed, MotorDoing* doing) {
  constexpr double kWorseBy = 3;  // Standard deviations.
  const auto in_force = DelaysInForce(doing);
  if (!in_force) return;
  const Delays aligned = Aligned(*in_force, before);
  if (!SetDelays(aligned, doing)) return;
  const auto after = MoveAndTime(speed.asked_unit_s, doing);
  if (!after) return;
  const double was_s = Skew_s(before), is_s = Skew_s(*after);
  doing->Say(fmt::format("axes were apart by {:.3f} ms, with the delays {:.3f} ms",
                         was_s / SFromMs(1.0),
                         is_s / SFromMs(1.0)));
  const bool is_worse =
      is_s > was_s + kWorseBy * SkewSd_s(before, speed.half_way_unit_s, *doing);
  if (is_worse) {
    doing->Warn("that is worse: the delays are as they were");
    SetDelays(*in_force, doing);
  }
  for (const auto& [axis, delay_s] : aligned) {
    doing->Step({.quantity = "start_delay." + MotorAxisName(axis),
                 .unit = "s",
                 .before = in_force->at(axis),
                 .after = is_worse ? in_force->at(axis) : delay_s,
                 .verdict = is_worse ? Verdict::kRolledBack : Verdict::kApplied,
                 .message = "M816"});
  }
  if (!is_worse) {
    doing->Say("delays (M816) are of no record: set them again after a power-up");
  }
  doing->done().found.skew_s = is_worse ? was_s : is_s;
}

}  // namespace

MotorResult RunAxisSync(MotorAxes* axes, const MotorOptions& options) {
  MotorDoing doing("axis_sync", options, axes);
  const auto servos = std::ranges::count_if(
      options.axes, [&](std::size_t axis) { return axes->drawing(axis).is_servo; });
  SayOpenLoop(&doing);
  if (servos < 2) {
    doing.Say("synchrony is between two axes that count: name two servos");
    doing.Confess("of fewer than two servos nothing tells whether they move together",
                  "start_lead." + MotorAxisName(options.axes.front()));
    return doing.Take();
  }
  if (!HomeAll(&doing)) return doing.Take();
  const auto common_unit_s = doing.CommonSpeed_unit_s();
  if (!common_unit_s) return doing.Take();
  double speed_unit_s = *common_unit_s;
  const auto before = doing.TrySlower(*common_unit_s, [&](double attempt_unit_s) {
    speed_unit_s = attempt_unit_s;
    return MoveAndTime(attempt_unit_s, &doing);
  });
  if (!before) return doing.Take();
  doing.done().found.skew_s = Skew_s(*before);
  const auto half_way_unit_s = HalfWaySpeed_unit_s(speed_unit_s, &doing);
  if (!half_way_unit_s) return doing.Take();
  TellLeads(*before, *half_way_unit_s, &doing);
  if (options.is_as_published) return doing.Take();
  Align(*before,
        {.asked_unit_s = speed_unit_s, .half_way_unit_s = *half_way_unit_s},
        &doing);
  return doing.Take();
}

}  // namespace caltwin
