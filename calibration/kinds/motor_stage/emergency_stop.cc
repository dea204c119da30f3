#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include <fmt/format.h>

#include "calibration/kinds/motor_stage/foretell_stop.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr double kFromMin_unit = 10;  // Where the move begins.

// Where the move begins; slower where something hinders that. (The stop itself is tried
// at one speed: slower it would be another one.)
bool GoToStart(MotorDoing* doing) {
  MotorAxes& axes = doing->axes();
  return std::ranges::all_of(doing->options().axes, [&](std::size_t axis) {
    const MotorAxisDrawing& d = axes.drawing(axis);
    return doing->TrySlower(d.max_velocity_unit_s / 2, [&](double speed_unit_s) {
      return doing->Did(axes.MoveTo(axis, d.min_unit + kFromMin_unit, speed_unit_s));
    });
  });
}

// The acceleration of all of them together: the least in force (M201).
std::optional<double> LeastAcceleration(MotorDoing* doing) {
  double least_unit_s2 = std::numeric_limits<double>::max();
  for (const std::size_t axis : doing->options().axes) {
    const auto in_force = doing->Got(doing->axes().Field(201, axis));
    if (!in_force) return std::nullopt;
    least_unit_s2 = std::min(least_unit_s2, *in_force);
  }
  return least_unit_s2;
}

// Room for speeding up, some way at that speed, and slowing down; else it says what the
// travel allows.
bool HasRoom(double way_unit, double slowest_unit_s2, MotorDoing* doing) {
  for (const std::size_t axis : doing->options().axes) {
    const MotorAxisDrawing& d = doing->axes().drawing(axis);
    const auto high_unit = doing->Got(doing->axes().Field(208, axis));
    if (!high_unit) return false;
    const double room_unit =
        std::min(d.max_unit, *high_unit) - d.min_unit - kFromMin_unit;
    if (way_unit <= room_unit) continue;
    const double most_unit_s =
        std::sqrt(std::max(0.0, room_unit - 2 * doing->options().distance_unit) *
                  slowest_unit_s2);
    doing->Fail({.reply = fmt::format(
                     "{0} needs {1:.4g} {2} to get to that speed and back with {3:.4g} "
                     "{2}/s2 (M201), and has {4:.4g}: nothing moved. Up to {5:.3g} "
                     "{2}/s its stop can be tried",
                     MotorAxisName(axis),
                     way_unit,
                     d.unit(),
                     slowest_unit_s2,
                     room_unit,
                     most_unit_s)});
    return false;
  }
  return true;
}

// Into the move, and the relay opens half way.
bool StopInMotion(double speed_unit_s, MotorDoing* doing) {
  MotorAxes& axes = doing->axes();
  const MotorOptions& o = doing->options();
  const auto slowest_unit_s2 = LeastAcceleration(doing);
  if (!slowest_unit_s2) return false;
  const double ramp_unit = speed_unit_s * speed_unit_s / *slowest_unit_s2;
  const double way_unit = ramp_unit + 2 * o.distance_unit;
  if (!HasRoom(way_unit, *slowest_unit_s2, doing) || !GoToStart(doing)) return false;
  const double half_s = (way_unit / speed_unit_s + speed_unit_s / *slowest_unit_s2) / 2;
  if (!doing->Did(axes.ArmRelay(half_s))) return false;
  const auto moved = axes.MoveTogether(o.axes, way_unit, speed_unit_s);
  if (moved) {
    doing->Alert(o.axes.front(), "the emergency stop did not stop the axes");
    return false;
  }
  if (moved.error().reply.find("emergency stop") != std::string::npos) return true;
  doing->Fail(moved.error());
  return false;
}

// Whether it went as fast as was foretold: else its stop tells nothing of that.
bool WentAsTold(std::size_t axis,
                const StopSays& says,
                double speed_unit_s,
                MotorDoing* doing) {
  constexpr double kSame = 0.01;
  if (std::abs(std::abs(says.told_unit_s) / speed_unit_s - 1) <= kSame) return true;
  doing->Fail(
      {.reply = fmt::format("{} went at {:.4g} {}/s when the contact opened, not "
                            "at {:.4g}: its stop tells nothing of that",
                            MotorAxisName(axis),
                            std::abs(says.told_unit_s),
                            doing->axes().drawing(axis).unit(),
                            speed_unit_s)});
  return false;
}

std::string Milliseconds(double seconds) {
  return fmt::format("{:.2f}", seconds / SFromMs(1.0));
}

// What braked so long, where that is more than was foretold.
void CompareWithForecast(std::size_t axis,
                         const StopForecast& f,
                         const StopSays& says,
                         MotorDoing* doing) {
  constexpr double kClear = 3;  // Standard deviations.
  const MotorAxisDrawing& d = doing->axes().drawing(axis);
  const double brake_s = says.standstill_s - says.brakes_s;
  const double late_s = brake_s - f.braked_s;
  if (late_s <= kClear * std::hypot(f.braked_sd_s, says.sd_s)) return;
  doing->Warn(fmt::format(
      "{} stood after {} ms, {} were foretold: it brakes like {:.3g} {} in place of "
      "{:g}, or its motor gives {:.0f} % of its force, or its load came late across a "
      "gap",
      MotorAxisName(axis),
      Milliseconds(says.standstill_s),
      Milliseconds(f.standstill_s),
      d.total_inertia() * brake_s / f.braked_s,
      d.is_rotary ? "kg m2" : "kg",
      d.total_inertia(),
      PercentFromFraction(f.braked_s / brake_s)));
}

// The verdict as measured; where it is worse than the foretold one, a warning. A load
// that is still in its gap when its motor stands is seen by no counter: then both must
// be in time.
void JudgeStandstill(std::size_t axis,
                     const StopForecast& f,
                     const StopSays& says,
                     MotorDoing* doing) {
  constexpr double kClear = 2;  // Standard deviations.
  const MotorOptions& o = doing->options();
  const bool is_counted = says.stood && says.standstill_s <= o.within_s;
  const bool is_in_gap = f.coasts_s > 0;
  const bool is_within = is_counted && (!is_in_gap || f.standstill_s <= o.within_s);
  std::string words =
      fmt::format("{} stood after {:.3f} +- {:.3f} ms: {}within {:g} ms",
                  MotorAxisName(axis),
                  says.standstill_s / SFromMs(1.0),
                  says.sd_s / SFromMs(1.0),
                  is_counted ? "" : "NOT ",
                  o.within_s / SFromMs(1.0));
  if (std::abs(says.standstill_s - o.within_s) < kClear * says.sd_s) {
    words += ", but too close to it for the counter to be sure";
  }
  const double crept_s = says.rests_s - says.standstill_s;
  if (crept_s > 3 * doing->axes().bench().stop_tick_s) {
    words +=
        fmt::format("; it crept on, slower than a twentieth of that, until {:.2f} ms",
                    says.rests_s / SFromMs(1.0));
  }
  if (is_in_gap) {
    words += fmt::format(
        "; so says the motor's counter, its load stands after {:.2f} "
        "ms by the forecast, {}within",
        f.standstill_s / SFromMs(1.0),
        is_within ? "" : "NOT ");
  }
  if (!is_within && f.standstill_s <= o.within_s) {
    doing->Warn(words);
  } else {
    doing->Say(words);
  }
  doing->done().found.stopped_within =
      is_within && doing->done().found.stopped_within.value_or(true);
}

// Its counter shows a gap that nobody told.
void TellKnock(std::size_t axis, const StopSays& says, MotorDoing* doing) {
  const auto gap = GapOf(axis, doing);
  if (!gap || gap->gap_unit > 0 || !says.is_knocked) return;
  doing->Warn(fmt::format(
      "{} did not brake evenly, its load hit it across a gap: it needs measuring, run "
      "motor_backlash (corrected) first",
      MotorAxisName(axis)));
}

bool ReadStops(const StopForecasts& forecasts, double speed_unit_s, MotorDoing* doing) {
  const MotorOptions& o = doing->options();
  double slowest_s = 0;
  for (const std::size_t axis : o.axes) {
    const auto says = doing->Got(doing->axes().LastStop(axis));
    if (!says || !WentAsTold(axis, *says, speed_unit_s, doing)) return false;
    const bool is_servo = doing->axes().drawing(axis).is_servo;
    if (is_servo) slowest_s = std::max(slowest_s, says->standstill_s);
    const std::string name = MotorAxisName(axis);
    doing->Step(
        {.quantity = "standstill_ms." + name,
         .unit = "ms",
         .after = says->standstill_s / SFromMs(1.0),
         .verdict = Verdict::kMeasured,
         .message = fmt::format("{} after {:.3f} {}, at most {:.1f} A, {}{}",
                                says->stood ? "stood" : "still moving",
                                says->path_unit,
                                doing->axes().drawing(axis).unit(),
                                says->peak_a,
                                says->is_disabled ? "drive off" : "DRIVE STILL ON",
                                is_servo ? "" : "; open-loop: when its pulses ended")});
    if (is_servo) {
      doing->Found({.name = "standstill_ms." + name,
                    .unit = "ms",
                    .value = says->standstill_s / SFromMs(1.0),
                    .sd = says->sd_s / SFromMs(1.0),
                    .identifiable = true});
      JudgeStandstill(axis, forecasts.at(axis), *says, doing);
      CompareWithForecast(axis, forecasts.at(axis), *says, doing);
      TellKnock(axis, *says, doing);
    }
    if (!says->is_disabled) doing->Alert(axis, name + ": its drive is still on");
  }
  doing->done().found.standstill_s = slowest_s;
  return true;
}

using IndexCounts = std::map<std::size_t, double>;

// The counter at the next index.
std::optional<double> NextIndex(std::size_t axis, MotorDoing* doing) {
  const auto top_unit_s = doing->TopSpeed_unit_s(axis);
  if (!top_unit_s || !MakeRoom(axis, doing)) return std::nullopt;
  const auto index = FindIndex(axis,
                               doing->axes().drawing(axis).lead_unit,
                               doing->options().slow * *top_unit_s,
                               doing);
  if (!index) return std::nullopt;
  return static_cast<double>(*index);
}

// Where each servo's counter has its indices before the stop: home need not be one (as
// published it is not).
std::optional<IndexCounts> IndicesBefore(MotorDoing* doing) {
  IndexCounts counts;
  for (const std::size_t axis : doing->options().axes) {
    if (!doing->axes().drawing(axis).is_servo) continue;
    const auto index = NextIndex(axis, doing);
    if (!index) return std::nullopt;
    counts[axis] = *index;
  }
  return counts;
}

// Whole turns from the index before the stop to one after it?
std::optional<bool> KeptItsPosition(std::size_t axis,
                                    double before_pulses,
                                    MotorDoing* doing) {
  const auto per_rev = doing->Got(doing->axes().Field(812, axis));
  const auto after_pulses = per_rev ? NextIndex(axis, doing) : std::nullopt;
  if (!after_pulses) return std::nullopt;
  const double gone_pulses = *after_pulses - before_pulses;
  const double off_pulses = gone_pulses - *per_rev * std::round(gone_pulses / *per_rev);
  const bool is_kept = std::abs(off_pulses) <= doing->options().threshold_pulses;
  if (is_kept) {
    doing->Say(
        fmt::format("{}: position kept but for whole turns of its motor, which an "
                    "index cannot tell: it is where the counter has it",
                    MotorAxisName(axis)));
    return true;
  }
  ++doing->done().found.positions_lost;
  doing->Warn(
      fmt::format("{}: position LOST, the counter is {:+.0f} pulses off at the "
                  "index: homed again",
                  MotorAxisName(axis),
                  off_pulses));
  return false;
}

bool GoOn(std::size_t axis, const IndexCounts& before, MotorDoing* doing) {
  MotorAxes& axes = doing->axes();
  MotorOptions home = doing->options();
  home.axes = {axis};
  home.is_as_published = false;
  const std::string name = MotorAxisName(axis);
  if (axes.drawing(axis).is_servo) {
    const auto kept = KeptItsPosition(axis, before.at(axis), doing);
    if (!kept) return false;
    if (*kept) return true;
  } else {
    doing->Say(name + ": open-loop, its position is not certain: homed again");
    if (!KeepHomeOffset(axis, &home, doing)) return false;
  }
  MotorResult homed = axes.drawing(axis).is_servo ? RunServoHome(&axes, home)
                                                  : RunStepperHome(&axes, home);
  const double lost_unit = homed.found.lost_unit.value_or(0);
  const bool is_homed = doing->Absorb(std::move(homed));
  if (lost_unit != 0) {
    ++doing->done().found.positions_lost;
    doing->Warn(
        fmt::format("{}: position LOST in the stop, {:+.3f} {}: such a stop is "
                    "not to be called feasible",
                    name,
                    lost_unit,
                    axes.drawing(axis).unit()));
  }
  return is_homed;
}

// Of the stop as it went, all axes together.
void TellVerdict(MotorDoing* doing) {
  const MotorFindings& found = doing->done().found;
  std::string words = found.stopped_within.has_value()
                          ? fmt::format("verdict: servos stood {}within {:g} ms",
                                        *found.stopped_within ? "" : "NOT ",
                                        doing->options().within_s / SFromMs(1.0))
                          : std::string("verdict: no axis shows when it stood");
  words += found.positions_lost == 0
               ? ", no position was seen to be lost"
               : fmt::format(", positions lost: {}", found.positions_lost);
  doing->Say(words);
}

// Without power their rotors were anywhere, though nobody asked for them.
void TellOtherSteppers(MotorDoing* doing) {
  for (std::size_t axis = 0; axis < kNumMotorAxes; ++axis) {
    const auto& asked = doing->options().axes;
    const bool is_other = !doing->axes().drawing(axis).is_servo &&
                          std::ranges::find(asked, axis) == asked.end();
    if (!is_other) continue;
    const auto says = doing->Got(doing->axes().Drive(axis));
    if (!says || !says->was_homed || says->is_homed) continue;
    doing->Warn(fmt::format(
        "{} was without power in the stop, and is homed no more: home it again",
        MotorAxisName(axis)));
  }
}

}  // namespace

MotorResult RunEmergencyStop(MotorAxes* axes, const MotorOptions& options) {
  MotorDoing doing("emergency_stop", options, axes);
  for (const std::size_t axis : options.axes) {
    if (!doing.IsHomed(axis)) return doing.Take();
  }
  const auto common_unit_s = doing.CommonSpeed_unit_s();
  if (!common_unit_s) return doing.Take();
  const double speed_unit_s = *common_unit_s;
  const auto forecasts = ForetellStops(speed_unit_s, &doing);
  if (!forecasts) return doing.Take();
  const auto indices = IndicesBefore(&doing);
  if (!indices || !StopInMotion(speed_unit_s, &doing) ||
      !ReadStops(*forecasts, speed_unit_s, &doing) || !doing.Did(axes->Resume())) {
    return doing.Take();
  }
  for (const std::size_t axis : options.axes) {
    if (!GoOn(axis, *indices, &doing)) return doing.Take();
  }
  TellVerdict(&doing);
  TellOtherSteppers(&doing);
  doing.Say("resumed");
  return doing.Take();
}

}  // namespace caltwin
