#include <cmath>

#include <fmt/format.h>

#include "calibration/estimate/expanded.h"
#include "calibration/kinds/motor_stage/doing.h"

namespace caltwin {
namespace {

constexpr double kReach = 1.2;  // Of the travel that is gone to look for a switch.

double BetweenSwitches(const MotorAxisDrawing& drawing) {
  return drawing.max_switch_unit - drawing.min_switch_unit;
}

// Why the axis was stopped on its way to MIN: from there to MAX is farther than the
// switches are apart where it stood at its hard stop.
std::string WhyBlocked(std::size_t axis, double speed_unit_s, MotorDoing* doing) {
  constexpr double kClear_unit = 2;
  MotorAxes& axes = doing->axes();
  const MotorAxisDrawing& drawing = axes.drawing(axis);
  const double apart_unit = BetweenSwitches(drawing);
  const std::string name = MotorAxisName(axis);
  const auto from = axes.Count(axis);
  const auto pulses = axes.Field(92, axis);
  const bool is_off = from && pulses && axes.MoveBy(axis, kClear_unit, speed_unit_s) &&
                      axes.SeekSwitch(axis, kReach * apart_unit, speed_unit_s);
  const auto to = axes.Count(axis);
  if (!is_off || !to) {
    return fmt::format("motion of {} is blocked both ways", name);
  }
  const double far_unit = static_cast<double>(*to - *from) / *pulses;
  if (far_unit > apart_unit) {
    return fmt::format(
        "end switch MIN of {} not detected: it went on to its hard stop, "
        "{:.1f} {} from MAX, where the switches are {:.1f} apart",
        name,
        far_unit,
        drawing.unit(),
        apart_unit);
  }
  return fmt::format(
      "motion of {} is blocked {:.1f} {} before MIN: something is in the way",
      name,
      apart_unit - far_unit,
      drawing.unit());
}

// Off a switch that is closed already.
bool LeaveSwitch(std::size_t axis, double speed_unit_s, MotorDoing* doing) {
  MotorAxes& axes = doing->axes();
  const auto pressed = doing->Got(axes.IsPressed(axis, /*is_min=*/true));
  if (!pressed) return false;
  const double off_unit = axes.drawing(axis).stop_unit;
  return !*pressed || doing->Did(axes.MoveBy(axis, off_unit, speed_unit_s));
}

}  // namespace

bool MayHomeAtScale(std::size_t axis,
                    double pulses_per_unit,
                    double pulses_per_rev,
                    MotorDoing* doing) {
  constexpr double kClear = 0.001;  // What steps per mm are to be right to.
  constexpr double kHopeless = 0.1;
  const MotorAxisDrawing& d = doing->axes().drawing(axis);
  const double turn_unit = pulses_per_rev / pulses_per_unit;
  const double off = std::abs(turn_unit / d.lead_unit - 1);
  if (off <= kClear) return true;
  const std::string words = fmt::format(
      "a turn of {0} is {1:.6g} {2} by its record ({3:.6g} pulses by M812, {4:.6g} a "
      "{2} "
      "by M92) and {5:.6g} as drawn: its lengths would be wrong, set M92 (steps per "
      "{2}) "
      "or "
      "M812 first",
      MotorAxisName(axis),
      turn_unit,
      d.unit(),
      pulses_per_rev,
      pulses_per_unit,
      d.lead_unit);
  if (off <= kHopeless) {
    doing->Warn(words);
    return true;
  }
  doing->Fail({.reply = words + "; nothing moved"});
  return false;
}

bool KeepHomeOffset(std::size_t axis, MotorOptions* home, MotorDoing* doing) {
  const auto stored_unit = doing->Got(doing->axes().Field(206, axis));
  if (!stored_unit) return false;
  const bool is_kept = *stored_unit > 0;
  if (is_kept) home->final_back_off_unit = *stored_unit;
  return true;
}

bool ShiftLimits(std::size_t axis, double farther_unit, MotorDoing* doing) {
  constexpr double kSame_unit = 1e-3;
  MotorAxes& axes = doing->axes();
  const MotorAxisDrawing& d = axes.drawing(axis);
  const auto high_unit = doing->Got(axes.Field(208, axis));
  const auto low_unit = doing->Got(axes.LowerLimit(axis));
  if (!high_unit || !low_unit) return false;
  const bool is_factory = std::abs(*high_unit - d.max_unit) < kSame_unit &&
                          std::abs(*low_unit - d.min_unit) < kSame_unit;
  if (is_factory || std::abs(farther_unit) < kSame_unit) return true;
  doing->Warn(
      fmt::format("zero of {} stands {:+.3f} {} from where its limits were "
                  "measured: they go along, {:.3f} .. {:.3f} now",
                  MotorAxisName(axis),
                  farther_unit,
                  d.unit(),
                  *low_unit - farther_unit,
                  *high_unit - farther_unit));
  return doing->Did(
      axes.SetLimits(axis, *low_unit - farther_unit, *high_unit - farther_unit));
}

bool MakeRoom(std::size_t axis, MotorDoing* doing) {
  constexpr double kTurns = 2.5;
  MotorAxes& axes = doing->axes();
  const MotorAxisDrawing& d = axes.drawing(axis);
  const auto high_unit = doing->Got(axes.Field(208, axis));
  const auto count = doing->Got(axes.Count(axis));
  const auto pulses = doing->Got(axes.Field(92, axis));
  const auto top_unit_s = doing->TopSpeed_unit_s(axis);
  if (!high_unit || !count || !pulses || !top_unit_s) return false;
  const double last_unit = std::min(*high_unit, d.max_unit) - kTurns * d.lead_unit;
  if (static_cast<double>(*count) / *pulses <= last_unit) return true;
  return doing->Did(
      axes.MoveTo(axis, last_unit, doing->options().medium * *top_unit_s));
}

std::optional<double> SeenLate(std::size_t axis,
                               double speed_unit_s,
                               MotorDoing* doing) {
  const auto acceleration_unit_s2 = doing->Got(doing->axes().Field(201, axis));
  if (!acceleration_unit_s2) return std::nullopt;
  const MotorStageDrawing& drawing = doing->axes().bench().drawing;
  const double known_s = drawing.poll_s / 2 + drawing.transfer_s;
  return speed_unit_s * known_s +
         speed_unit_s * speed_unit_s / (2 * *acceleration_unit_s2);
}

bool StopsBehindASwitch(std::size_t axis,
                        double speed_unit_s,
                        MotorDoing* doing,
                        std::string_view option) {
  MotorAxes& axes = doing->axes();
  const MotorAxisDrawing& d = axes.drawing(axis);
  const auto late_unit = SeenLate(axis, speed_unit_s, doing);
  if (!late_unit) return false;
  const double at_most_unit =
      *late_unit + speed_unit_s * axes.bench().drawing.poll_s / 2;
  if (at_most_unit <= d.stop_unit) return true;
  doing->Fail({.reply = fmt::format(
                   "at {0:g} {1}/s {2} would stop up to {3:.2f} {1} beyond its switch, "
                   "and its hard stop is {4:g} beyond: nothing moved, choose a smaller "
                   "'{5}'",
                   speed_unit_s,
                   d.unit(),
                   MotorAxisName(axis),
                   at_most_unit,
                   d.stop_unit,
                   option)});
  return false;
}

double SwitchSigma(const MotorBench& bench, std::size_t axis, double speed_unit_s) {
  const double polled_unit = speed_unit_s * bench.drawing.poll_s / std::sqrt(12.0);
  return std::hypot(bench.drawing.axes[axis].switch_scatter_unit, polled_unit);
}

std::vector<Contribution> SwitchBudget(const MotorBench& bench,
                                       std::size_t axis,
                                       double speed_unit_s) {
  return {{.input = "switch", .u = bench.drawing.axes[axis].switch_scatter_unit},
          {.input = "expander's period",
           .u = speed_unit_s * bench.drawing.poll_s / std::sqrt(12.0)}};
}

Uncertain OfCarriage(double way_unit,
                     const Uncertain& gap_unit,
                     std::vector<Contribution> budget) {
  if (gap_unit.identifiable) {
    way_unit -= gap_unit.value / 2;
    budget.push_back({.input = "half the gap", .u = gap_unit.sd / 2});
  }
  return WithBudget(way_unit, std::move(budget));
}

bool MayBeAGap(double gap_unit, std::size_t axis, const MotorDoing& doing) {
  constexpr double kMost_turns = 0.2;
  return gap_unit <= kMost_turns * doing.axes().drawing(axis).lead_unit;
}

std::optional<Uncertain> CompensatedGap(std::size_t axis,
                                        const std::string& quantity,
                                        MotorDoing* doing) {
  const auto gap_unit = doing->Got(doing->axes().Field(425, axis));
  const auto pulses = doing->Got(doing->axes().Field(92, axis));
  if (!gap_unit || !pulses) return std::nullopt;
  const bool is_believed = MayBeAGap(*gap_unit, axis, *doing);
  if (!is_believed) {
    doing->Warn(fmt::format(
        "M425 of {} holds {:g} {}, more than a fifth of a turn: it is no gap that was "
        "measured and is not taken off; run motor_backlash (corrected)",
        MotorAxisName(axis),
        *gap_unit,
        doing->axes().drawing(axis).unit()));
  }
  if (*gap_unit > 0 && is_believed) {
    return Uncertain{.value = *gap_unit, .sd = 1 / *pulses, .identifiable = true};
  }
  const std::string name = MotorAxisName(axis);
  const bool is_servo = doing->axes().drawing(axis).is_servo;
  doing->done().result.observability.push_back(
      {fmt::format(
           "a switch does not tell {0}.{1} from half a gap behind the motor; {2}",
           quantity,
           name,
           is_servo ? "motor_backlash with a gauge on the carriage does"
                    : "a gauge on the carriage, read from both sides, does "
                      "(M425 then)"),
       {{quantity + "." + name, std::sqrt(0.8)},
        {"backlash." + name, -std::sqrt(0.2)}}});
  return Uncertain{};
}

bool FindMinSwitch(std::size_t axis, double speed_unit_s, MotorDoing* doing) {
  MotorAxes& axes = doing->axes();
  const MotorAxisDrawing& drawing = axes.drawing(axis);
  constexpr double kPatience_s = 3600;
  const double search_s = BetweenSwitches(drawing) / speed_unit_s;
  if (search_s > kPatience_s) {
    doing->Fail({.reply = fmt::format(
                     "at {:.3g} {}/s the switch of {} would be looked for for up to "
                     "{:.1f} h: is M203 meant to be so low?",
                     speed_unit_s,
                     drawing.unit(),
                     MotorAxisName(axis),
                     search_s / kPatience_s)});
    return false;
  }
  if (!doing->Did(axes.Enable(axis, true))) return false;
  if (!LeaveSwitch(axis, speed_unit_s, doing)) return false;
  const auto found =
      axes.SeekSwitch(axis, -kReach * BetweenSwitches(drawing), speed_unit_s);
  if (found) return true;
  auto condition = ConditionOf(found.error(), axes.bench().drawing);
  if (!condition) {
    doing->Fail(found.error());
    return false;
  }
  if (condition->kind == MotorCondition::Kind::kBlocked) {
    condition->words = WhyBlocked(axis, speed_unit_s, doing);
    condition->remedy.clear();
  }
  doing->Meet(*std::move(condition));
  return false;
}

std::optional<std::int64_t> FindIndex(std::size_t axis,
                                      double lead_unit,
                                      double speed_unit_s,
                                      MotorDoing* doing) {
  constexpr double kHunt = 1.2;  // Turns that are gone to look for it.
  MotorAxes& axes = doing->axes();
  const auto attempt = [&](double v_unit_s) -> std::optional<std::int64_t> {
    if (!doing->Did(axes.ClearDrive(axis))) return std::nullopt;
    const auto found = axes.SeekIndex(axis, kHunt * lead_unit, v_unit_s);
    if (!found) {
      auto condition = ConditionOf(found.error(), axes.bench().drawing);
      const bool is_missing =
          condition && condition->kind == MotorCondition::Kind::kIndexMissing;
      // Back first: what hinders that is met in its place.
      if (is_missing && !doing->Did(axes.MoveBy(axis, -kHunt * lead_unit, v_unit_s))) {
        return std::nullopt;
      }
      if (!is_missing) {
        doing->Fail(found.error());
        return std::nullopt;
      }
      condition->words = fmt::format("no index pulse of {} within one revolution",
                                     MotorAxisName(axis));
      doing->Meet(*std::move(condition));
      return std::nullopt;
    }
    if (!doing->Did(axes.WaitComplete())) return std::nullopt;
    const auto says = doing->Got(axes.Drive(axis));
    if (says && !says->index) {
      doing->Fail({.reply = MotorAxisName(axis) + ": M814 tells no index"});
    }
    return says ? says->index : std::nullopt;
  };
  return doing->TrySlower(speed_unit_s, attempt);
}

}  // namespace caltwin
