#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "calibration/kinds/motor_stage/switch_looks.h"

namespace caltwin {
namespace {

/// What is known of an axis before its travel is measured.
struct Travel {
  std::size_t axis = 0;
  double pulses_per_unit = 1;
  double home_offset_unit = 0;
};

// Stopped beyond where the MAX switch should be: that is dead. Before it: an obstacle.
void TellWhyBlocked(const Travel& travel, MotorCondition condition, MotorDoing* doing) {
  const MotorAxisDrawing& d = doing->axes().drawing(travel.axis);
  const auto count = doing->Got(doing->axes().Count(travel.axis));
  if (!count) return;
  const double apart_unit = d.max_switch_unit - d.min_switch_unit;
  const double from_min_unit =
      static_cast<double>(*count) / travel.pulses_per_unit + travel.home_offset_unit;
  const std::string name = MotorAxisName(travel.axis);
  if (from_min_unit > apart_unit) {
    condition.words = fmt::format(
        "end switch MAX of {} not detected: it went on to its hard stop, {:.1f} {} "
        "from "
        "MIN, where the switches are {:.1f} apart",
        name,
        from_min_unit,
        d.unit(),
        apart_unit);
    condition.remedy = "is its wire on?";
    condition.can_move = true;
  } else {
    condition.words = fmt::format("motion of {} is blocked {:.1f} {} before MAX",
                                  name,
                                  apart_unit - from_min_unit,
                                  d.unit());
  }
  doing->Meet(std::move(condition));
}

// From home to MAX at that speed; the looks at it.
std::optional<SwitchLooks> GoToMax(const Travel& travel,
                                   double speed_unit_s,
                                   MotorDoing* doing) {
  MotorAxes& axes = doing->axes();
  const std::size_t axis = travel.axis;
  const MotorAxisDrawing& d = axes.drawing(axis);
  const double reach_unit = 1.2 * (d.max_switch_unit - d.min_switch_unit);
  if (!doing->Did(axes.MoveTo(axis, 0, speed_unit_s))) return std::nullopt;
  const auto found = axes.SeekSwitch(axis, reach_unit, speed_unit_s);
  if (!found) {
    auto condition = ConditionOf(found.error(), axes.bench().drawing);
    const bool is_blocked =
        condition && condition->kind == MotorCondition::Kind::kBlocked;
    if (is_blocked) {
      TellWhyBlocked(travel, *std::move(condition), doing);
    } else {
      doing->Fail(found.error());
    }
    return std::nullopt;
  }
  if (!doing->Did(axes.WaitComplete())) return std::nullopt;
  if (!doing->options().is_as_published) {
    return LookFinely({.axis = axis,
                       .sense = +1,
                       .came_unit_s = speed_unit_s,
                       .fine_unit_s = doing->options().fine_unit_s},
                      doing->options().touches,
                      travel.pulses_per_unit,
                      doing);
  }
  const auto count = doing->Got(axes.Count(axis));
  if (!count) return std::nullopt;
  return SwitchLooks{.at_pulses = {static_cast<double>(*count)},
                     .sigma_unit = SwitchSigma(axes.bench(), axis, speed_unit_s)};
}

// The working range; home stays in it.
void KeepLimits(const Travel& travel,
                const SwitchLooks& looks,
                double speed_unit_s,
                MotorDoing* doing) {
  MotorAxes& axes = doing->axes();
  const std::size_t axis = travel.axis;
  const MotorAxisDrawing& d = axes.drawing(axis);
  const double margin_unit = doing->options().margin_unit;
  const double travel_unit = looks.mean_pulses() / travel.pulses_per_unit;
  const double low_unit = std::min(0.0, margin_unit - travel.home_offset_unit);
  const double high_unit = travel_unit - margin_unit;
  if (high_unit <= low_unit) {
    doing->Fail(
        {.reply = fmt::format("a margin of {:g} {} leaves nothing of the {:.3f} "
                              "from home to MAX: limits are as they were",
                              margin_unit,
                              d.unit(),
                              travel_unit)});
    return;
  }
  if (margin_unit > travel.home_offset_unit) {
    doing->Warn(fmt::format(
        "zero of {} stands {:.3f} {} from MIN, nearer than the margin of {:g}: the "
        "working range begins at zero",
        MotorAxisName(axis),
        travel.home_offset_unit,
        d.unit(),
        margin_unit));
  }
  const bool is_kept =
      doing->Did(axes.SetLimits(axis, low_unit, high_unit)) &&
      doing->Did(axes.MoveTo(axis, (low_unit + high_unit) / 2, speed_unit_s)) &&
      doing->Store(axis);
  if (!is_kept) return;
  const std::string name = "travel." + MotorAxisName(axis);
  doing->Step(
      {.quantity = name,
       .unit = d.unit(),
       .after = travel_unit,
       .verdict = Verdict::kApplied,
       .message = fmt::format(
           "working range {:.3f} .. {:.3f} {}", low_unit, high_unit, d.unit())});
  if (doing->options().is_as_published) {
    // The text states no uncertainty.
    doing->Found(
        {.name = name, .unit = d.unit(), .value = travel_unit, .identifiable = true});
    return;
  }
  const auto gap_unit = CompensatedGap(axis, "travel", doing);
  if (!gap_unit) return;
  doing->Found(name, d.unit(), OfCarriage(travel_unit, *gap_unit, looks.Budget()));
}

}  // namespace

MotorResult RunTravelLimits(MotorAxes* axes, const MotorOptions& options) {
  MotorDoing doing("travel_limits", options, axes);
  const std::size_t axis = options.axes.front();
  const auto pulses = doing.Got(axes->Field(92, axis));
  const auto per_rev = doing.Got(axes->Field(812, axis));
  const auto offset_unit = doing.Got(axes->Field(206, axis));
  const auto top_unit_s = doing.TopSpeed_unit_s(axis);
  if (!pulses || !per_rev || !offset_unit || !top_unit_s || !doing.IsHomed(axis)) {
    return doing.Take();
  }
  const Travel travel{
      .axis = axis, .pulses_per_unit = *pulses, .home_offset_unit = *offset_unit};
  const double slow_unit_s = options.slow * *top_unit_s;
  const bool may_begin = MayHomeAtScale(axis, *pulses, *per_rev, &doing) &&
                         (options.is_as_published ||
                          (doing.SetForNow(425, axis, 0) && doing.WithoutDelay(axis)));
  const bool stops = StopsBehindASwitch(axis, slow_unit_s, &doing) &&
                     (options.is_as_published ||
                      StopsBehindASwitch(axis, options.fine_unit_s, &doing, "fine"));
  if (!may_begin || !stops) return doing.Take();
  const auto looks = doing.TrySlower(slow_unit_s, [&](double speed_unit_s) {
    return GoToMax(travel, speed_unit_s, &doing);
  });
  if (looks) KeepLimits(travel, *looks, slow_unit_s, &doing);
  return doing.Take();
}

}  // namespace caltwin
