#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "calibration/estimate/expanded.h"
#include "calibration/motor_axes/doing.h"
#include "sim/base/mutant.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

using Moments = std::map<std::size_t, double>;  // When each servo was half way [s].

// Homes what is not homed yet, one after the other, and goes to the middle.
bool Prepare(MotorDoing* doing) {
  MotorAxes& axes = doing->axes();
  for (const std::size_t axis : doing->options().axes) {
    const MotorAxisDrawing& d = axes.drawing(axis);
    const auto says = doing->Got(axes.Drive(axis));
    if (!says) return false;
    if (!says->is_homed) {
      MotorOptions home = doing->options();
      home.axes = {axis};
      const MotorResult homed =
          d.is_servo ? RunServoHome(&axes, home) : RunStepperHome(&axes, home);
      for (const std::string& line : homed.result.messages) doing->Say(line);
      if (homed.result.ending != Ending::kDone) {
        doing->done().result.ending = homed.result.ending;
        return false;
      }
    }
    const double middle_unit = (d.min_unit + d.max_unit) / 2;
    if (!doing->Did(axes.MoveTo(axis, middle_unit, d.max_velocity_unit_s / 2))) {
      return false;
    }
  }
  return true;
}

double CommonSpeed_unit_s(const MotorAxes& axes, const MotorOptions& options) {
  double slowest_unit_s = std::numeric_limits<double>::max();
  for (const std::size_t axis : options.axes) {
    slowest_unit_s = std::min(slowest_unit_s, axes.drawing(axis).max_velocity_unit_s);
  }
  return options.medium * slowest_unit_s;
}

std::optional<Moments> MoveAndTime(double speed_unit_s, MotorDoing* doing) {
  MotorAxes& axes = doing->axes();
  const MotorOptions& o = doing->options();
  Moments moments;
  for (int i = 0; i < o.repeats; ++i) {
    if (!doing->Did(axes.MoveTogether(o.axes, o.distance_unit, speed_unit_s)) ||
        !doing->Did(axes.WaitComplete())) {
      return std::nullopt;
    }
    for (const std::size_t axis : o.axes) {
      const auto says = doing->Got(axes.Drive(axis));
      if (!says) return std::nullopt;
      if (!axes.drawing(axis).is_servo || !says->half_way_s) continue;
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

}  // namespace

MotorResult RunAxisSync(MotorAxes* axes, const MotorOptions& options) {
  MotorDoing doing("axis_sync", options, axes);
  if (!Prepare(&doing)) return doing.Take();
  SayOpenLoop(&doing);
  const double speed_unit_s = CommonSpeed_unit_s(*axes, options);
  const auto before = MoveAndTime(speed_unit_s, &doing);
  if (!before) return doing.Take();
  doing.done().found.skew_s = Skew_s(*before);
  const double latest_s = Latest(*before);
  for (const auto& [axis, at_s] : *before) {
    const double early_s = latest_s - at_s;
    doing.Found("start_lead." + MotorAxisName(axis),
                "s",
                LeadOf(axis, *before, speed_unit_s, doing));
    doing.Step(
        "start_lead." + MotorAxisName(axis),
        early_s,
        options.is_as_published ? early_s : 0,
        options.is_as_published ? Verdict::kMeasured : Verdict::kApplied,
        fmt::format("{:.3f} ms before the latest axis: {:.1f} um off the path at "
                    "{:g} {}/s; a delay of as much (M816) aligns it",
                    early_s / SFromMs(1.0),
                    UmFromMm(early_s * speed_unit_s),
                    speed_unit_s,
                    axes->drawing(axis).unit()));
    const double delay_s = Mutant("sync_delays_the_latest", early_s, -early_s);
    if (!options.is_as_published && !doing.Did(axes->SetDelay_s(axis, delay_s))) {
      return doing.Take();
    }
  }
  if (options.is_as_published) return doing.Take();
  const auto after = MoveAndTime(speed_unit_s, &doing);
  if (!after) return doing.Take();
  doing.done().found.skew_s = Skew_s(*after);
  doing.Say(fmt::format("axes were apart by {:.3f} ms, with the delays {:.3f} ms",
                        Skew_s(*before) / SFromMs(1.0),
                        Skew_s(*after) / SFromMs(1.0)));
  return doing.Take();
}

}  // namespace caltwin
