#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "calibration/motor_axes/doing.h"
#include "sim/base/mutant.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

double CommonSpeed_unit_s(const MotorAxes& axes, const MotorOptions& options) {
  double slowest_unit_s = std::numeric_limits<double>::max();
  for (const std::size_t axis : options.axes) {
    slowest_unit_s = std::min(slowest_unit_s, axes.drawing(axis).max_velocity_unit_s);
  }
  return options.medium * slowest_unit_s;
}

void Foretell(double speed_unit_s, MotorDoing* doing) {
  const MotorOptions& o = doing->options();
  bool all = true;
  for (const std::size_t axis : o.axes) {
    const MotorAxisDrawing& d = doing->axes().drawing(axis);
    const StopForecast f =
        ForecastStop(doing->axes().bench(), axis, speed_unit_s, o.within_s);
    const bool is_feasible = f.standstill_s <= o.within_s && f.holds;
    all = all && is_feasible;
    std::string words = fmt::format(
        "{} at {:g} {}/s: stands after {:.2f} +- {:.2f} ms and {:.3f} {}; {} within "
        "{:g} "
        "ms",
        MotorAxisName(axis),
        speed_unit_s,
        d.unit(),
        f.standstill_s / SFromMs(1.0),
        f.sd_s / SFromMs(1.0),
        f.path_unit,
        d.unit(),
        is_feasible ? "feasible" : "NOT feasible",
        o.within_s / SFromMs(1.0));
    if (!is_feasible) {
      words += fmt::format("; up to {:.0f} {}/s it is", f.fastest_unit_s, d.unit());
    }
    if (!f.holds) words += "; its field would let go, steps would be lost";
    if (is_feasible) {
      doing->Say(words);
    } else {
      doing->Warn(words);
    }
  }
  doing->done().found.stop_feasible = all;
}

// Into the move, and the relay opens half way.
bool StopInMotion(double speed_unit_s, MotorDoing* doing) {
  MotorAxes& axes = doing->axes();
  const MotorOptions& o = doing->options();
  double slowest_unit_s2 = std::numeric_limits<double>::max();
  for (const std::size_t axis : o.axes) {
    const MotorAxisDrawing& d = axes.drawing(axis);
    slowest_unit_s2 = std::min(slowest_unit_s2, d.acceleration_unit_s2);
    if (!doing->Did(axes.MoveTo(axis, d.min_unit + 10, d.max_velocity_unit_s / 2))) {
      return false;
    }
  }
  const double ramp_unit = speed_unit_s * speed_unit_s / slowest_unit_s2;
  const double way_unit = ramp_unit + 2 * o.distance_unit;
  const double half_s = (way_unit / speed_unit_s + speed_unit_s / slowest_unit_s2) / 2;
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

std::string Milliseconds(double seconds) {
  return fmt::format("{:.2f}", seconds / SFromMs(1.0));
}

// What braked so long, where that is more than was foretold.
void CompareWithForecast(std::size_t axis,
                         double speed_unit_s,
                         const StopSays& says,
                         MotorDoing* doing) {
  constexpr double kClear = 3;  // Standard deviations.
  const MotorOptions& o = doing->options();
  const MotorBench& bench = doing->axes().bench();
  const MotorAxisDrawing& d = doing->axes().drawing(axis);
  const StopForecast f = ForecastStop(bench, axis, speed_unit_s, o.within_s);
  const double late_s = says.standstill_s - f.standstill_s;
  if (late_s <= kClear * std::hypot(f.sd_s, says.sd_s)) return;
  const double brake_s = says.standstill_s - bench.stop_filter_s;
  doing->Warn(fmt::format(
      "{} stood after {} ms, {} were foretold: it brakes like {:.3g} {} in place of "
      "{:g}, or its motor gives {:.0f} % of its force",
      MotorAxisName(axis),
      Milliseconds(says.standstill_s),
      Milliseconds(f.standstill_s),
      d.total_inertia() * brake_s / (f.standstill_s - bench.stop_filter_s),
      d.is_rotary ? "kg m2" : "kg",
      d.total_inertia(),
      PercentFromFraction((f.standstill_s - bench.stop_filter_s) / brake_s)));
}

// The verdict as measured; where it is worse than the foretold one, a warning.
void JudgeStandstill(std::size_t axis,
                     double speed_unit_s,
                     const StopSays& says,
                     MotorDoing* doing) {
  constexpr double kClear = 2;  // Standard deviations.
  const MotorOptions& o = doing->options();
  const bool is_within = says.stood && says.standstill_s <= o.within_s;
  std::string words =
      fmt::format("{} stood after {:.3f} +- {:.3f} ms: {}within {:g} ms",
                  MotorAxisName(axis),
                  says.standstill_s / SFromMs(1.0),
                  says.sd_s / SFromMs(1.0),
                  is_within ? "" : "NOT ",
                  o.within_s / SFromMs(1.0));
  if (std::abs(says.standstill_s - o.within_s) < kClear * says.sd_s) {
    words += ", but too close to it for the counter to be sure";
  }
  const StopForecast f =
      ForecastStop(doing->axes().bench(), axis, speed_unit_s, o.within_s);
  if (!is_within && f.standstill_s <= o.within_s) {
    doing->Warn(words);
  } else {
    doing->Say(words);
  }
  doing->done().found.stopped_within =
      is_within && doing->done().found.stopped_within.value_or(true);
}

bool ReadStops(double speed_unit_s, MotorDoing* doing) {
  const MotorOptions& o = doing->options();
  double slowest_s = 0;
  for (const std::size_t axis : o.axes) {
    const auto says = doing->Got(doing->axes().LastStop(axis));
    if (!says) return false;
    const bool is_servo = doing->axes().drawing(axis).is_servo;
    if (is_servo) slowest_s = std::max(slowest_s, says->standstill_s);
    const std::string name = MotorAxisName(axis);
    doing->Step("standstill_ms." + name,
                o.within_s / SFromMs(1.0),
                says->standstill_s / SFromMs(1.0),
                Verdict::kMeasured,
                fmt::format("{} after {:.3f} {}, at most {:.1f} A, {}{}",
                            says->stood ? "stood" : "still moving",
                            says->path_unit,
                            doing->axes().drawing(axis).unit(),
                            says->peak_a,
                            says->is_disabled ? "drive off" : "DRIVE STILL ON",
                            is_servo ? "" : "; open-loop: when its pulses ended"));
    if (is_servo) {
      doing->Found("standstill_ms." + name,
                   "ms",
                   says->standstill_s / SFromMs(1.0),
                   says->sd_s / SFromMs(1.0));
      JudgeStandstill(axis, speed_unit_s, *says, doing);
      CompareWithForecast(axis, speed_unit_s, *says, doing);
    }
    if (!says->is_disabled) doing->Alert(axis, name + ": its drive is still on");
  }
  doing->done().found.standstill_s = slowest_s;
  return true;
}

using IndexCounts = std::map<std::size_t, double>;

// The counter at the next index.
std::optional<double> NextIndex(std::size_t axis, MotorDoing* doing) {
  MotorAxes& axes = doing->axes();
  const MotorAxisDrawing& d = axes.drawing(axis);
  const double slow_unit_s = doing->options().slow * d.max_velocity_unit_s;
  if (!doing->Did(axes.ClearDrive(axis)) ||
      !doing->Did(axes.SeekIndex(axis, 1.2 * d.lead_unit, slow_unit_s)) ||
      !doing->Did(axes.WaitComplete())) {
    return std::nullopt;
  }
  const auto says = doing->Got(axes.Drive(axis));
  if (!says || !says->index) return std::nullopt;
  return static_cast<double>(*says->index);
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
  const double reference_pulses =
      Mutant("stop_index_read_after",
             Mutant("stop_index_is_home", before_pulses, 0.0),
             *after_pulses);
  const double gone_pulses = *after_pulses - reference_pulses;
  const double off_pulses = gone_pulses - *per_rev * std::round(gone_pulses / *per_rev);
  const bool is_kept = std::abs(off_pulses) <= doing->options().threshold_pulses;
  doing->Say(fmt::format(
      "{}: {}",
      MotorAxisName(axis),
      is_kept ? "position kept, the index is where the counter has it"
              : fmt::format("position LOST, the counter is {:+.0f} pulses off at the "
                            "index: homed again",
                            off_pulses)));
  return is_kept;
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
  }
  const MotorResult homed = axes.drawing(axis).is_servo ? RunServoHome(&axes, home)
                                                        : RunStepperHome(&axes, home);
  for (const std::string& line : homed.result.messages) doing->Say(line);
  if (homed.result.ending == Ending::kDone) return true;
  doing->done().result.ending = homed.result.ending;
  return false;
}

}  // namespace

StopForecast ForecastStop(const MotorBench& bench,
                          std::size_t axis,
                          double speed_unit_s,
                          double within_s) {
  const MotorAxisDrawing& d = bench.drawing.axes[axis];
  const double inertia = d.total_inertia() * d.si_per_unit();
  if (d.is_servo) {
    const double slow_unit_s2 =
        (Mutant("stop_forgets_current", d.largest_force(), 1.1 * d.largest_force()) +
         d.friction) /
        inertia;
    const double brake_s = speed_unit_s / slow_unit_s2;
    return {.standstill_s = bench.stop_filter_s + brake_s,
            .sd_s = brake_s * bench.inertia_sigma,
            .path_unit = speed_unit_s * (bench.stop_filter_s + brake_s / 2),
            .fastest_unit_s = (within_s - bench.stop_filter_s) * slow_unit_s2};
  }
  // What its field holds falls to half at the highest feed.
  const double falls = d.largest_force() / (2 * d.max_velocity_unit_s);
  const double ramp_s = bench.stepper_stop_s;
  StopForecast f{.standstill_s = bench.stop_filter_s + ramp_s,
                 .path_unit = speed_unit_s * (bench.stop_filter_s + ramp_s / 2)};
  f.fastest_unit_s = (d.largest_force() + d.friction) / (inertia / ramp_s + falls);
  f.holds = speed_unit_s <= f.fastest_unit_s;
  return f;
}

MotorResult RunEmergencyStop(MotorAxes* axes, const MotorOptions& options) {
  MotorDoing doing("emergency_stop", options, axes);
  for (const std::size_t axis : options.axes) {
    const auto says = doing.Got(axes->Drive(axis));
    if (!says) return doing.Take();
    if (!says->is_homed) {
      doing.Fail({.reply = MotorAxisName(axis) + " is not homed: home it first"});
      return doing.Take();
    }
  }
  const double speed_unit_s = CommonSpeed_unit_s(*axes, options);
  Foretell(speed_unit_s, &doing);
  const auto indices = IndicesBefore(&doing);
  if (!indices || !StopInMotion(speed_unit_s, &doing) ||
      !ReadStops(speed_unit_s, &doing) || !doing.Did(axes->Resume())) {
    return doing.Take();
  }
  for (const std::size_t axis : options.axes) {
    if (!GoOn(axis, *indices, &doing)) return doing.Take();
  }
  doing.Say("resumed");
  return doing.Take();
}

}  // namespace caltwin
