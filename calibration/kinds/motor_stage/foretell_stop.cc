#include "calibration/kinds/motor_stage/foretell_stop.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "sim/base/units.h"

namespace caltwin {
namespace {

bool IsFeasible(const StopForecast& f, double within_s) {
  return f.standstill_s <= within_s && f.holds;
}

std::string ForetoldWords(std::size_t axis,
                          double speed_unit_s,
                          const StopForecast& f,
                          const MotorDoing& doing) {
  const MotorAxisDrawing& d = doing.axes().drawing(axis);
  const double within_s = doing.options().within_s;
  std::string words = fmt::format(
      "{} at {:g} {}/s: stands after {:.2f} +- {:.2f} ms and {:.3f} {}; {} within {:g} "
      "ms",
      MotorAxisName(axis),
      speed_unit_s,
      d.unit(),
      f.standstill_s / SFromMs(1.0),
      f.sd_s / SFromMs(1.0),
      f.path_unit,
      d.unit(),
      IsFeasible(f, within_s) ? "feasible" : "NOT feasible",
      within_s / SFromMs(1.0));
  if (f.coasts_s > 0) {
    words += fmt::format(
        "; its load coasts across the gap for {:.2f} ms yet when its "
        "motor stands",
        f.coasts_s / SFromMs(1.0));
  }
  const double brakes_after_s = doing.axes().bench().BrakesAfter_s();
  if (within_s <= brakes_after_s && d.is_servo) {
    words += fmt::format("; at no speed it is, its input alone takes {:g} ms",
                         brakes_after_s / SFromMs(1.0));
  } else if (!IsFeasible(f, within_s)) {
    words += fmt::format("; {} {:.0f} {}/s it is",
                         f.coasts_s > 0 ? "at" : "up to",
                         std::min(f.fastest_unit_s, d.max_velocity_unit_s),
                         d.unit());
  }
  if (!f.holds) words += "; its field would let go, steps would be lost";
  return words;
}

// Where the forecast leaves it open.
void WarnOfDoubt(std::size_t axis,
                 double speed_unit_s,
                 const StopForecast& f,
                 MotorDoing* doing) {
  constexpr double kClear = 2;  // Standard deviations.
  const double within_s = doing->options().within_s;
  const std::string name = MotorAxisName(axis);
  if (std::abs(f.standstill_s - within_s) < kClear * f.sd_s) {
    doing->Warn(name + ": too close to the limit for a forecast to be sure");
  }
  const bool is_servo = doing->axes().drawing(axis).is_servo;
  if (!is_servo && f.holds &&
      speed_unit_s > f.fastest_unit_s - kClear * f.fastest_sd_unit_s) {
    doing->Warn(fmt::format(
        "{}: its field holds up to {:.1f} +- {:.1f} {}/s: steps may be lost",
        name,
        f.fastest_unit_s,
        f.fastest_sd_unit_s,
        doing->axes().drawing(axis).unit()));
  }
}

// A gap that nobody measured, as large as a mechanic would let pass: does it matter?
void WarnOfUnknownGap(std::size_t axis, double speed_unit_s, MotorDoing* doing) {
  const MotorOptions& o = doing->options();
  const StopForecast f = ForecastStop(doing->axes().bench(),
                                      axis,
                                      {.speed_unit_s = speed_unit_s,
                                       .within_s = o.within_s,
                                       .gap_unit = o.tolerance_unit});
  if (f.standstill_s <= o.within_s) return;
  doing->Warn(fmt::format(
      "the gap of {} needs measuring: run motor_backlash (corrected) first. "
      "None is known by M425; across one of {:g} {} it would stand "
      "after {:.2f} ms",
      MotorAxisName(axis),
      o.tolerance_unit,
      doing->axes().drawing(axis).unit(),
      f.standstill_s / SFromMs(1.0)));
}

}  // namespace

std::optional<KnownGap> GapOf(std::size_t axis, MotorDoing* doing) {
  if (!doing->axes().drawing(axis).is_servo) return KnownGap{};
  const auto gap_unit = doing->Got(doing->axes().Field(425, axis));
  const auto pulses = doing->Got(doing->axes().Field(92, axis));
  if (!gap_unit || !pulses) return std::nullopt;
  // What can be none is as unknown as where nothing stands there.
  if (!MayBeAGap(*gap_unit, axis, *doing)) {
    return KnownGap{};
  }
  return KnownGap{.gap_unit = *gap_unit, .sd_unit = *gap_unit > 0 ? 1 / *pulses : 0};
}

std::optional<StopForecasts> ForetellStops(double speed_unit_s, MotorDoing* doing) {
  const MotorOptions& o = doing->options();
  StopForecasts forecasts;
  bool all = true;
  for (const std::size_t axis : o.axes) {
    const auto gap = GapOf(axis, doing);
    if (!gap) return std::nullopt;
    const StopForecast f = ForecastStop(doing->axes().bench(),
                                        axis,
                                        {.speed_unit_s = speed_unit_s,
                                         .within_s = o.within_s,
                                         .gap_unit = gap->gap_unit,
                                         .gap_sd_unit = gap->sd_unit});
    forecasts[axis] = f;
    const bool is_feasible = IsFeasible(f, o.within_s);
    all = all && is_feasible;
    const std::string words = ForetoldWords(axis, speed_unit_s, f, *doing);
    if (is_feasible) {
      doing->Say(words);
    } else {
      doing->Warn(words);
    }
    WarnOfDoubt(axis, speed_unit_s, f, doing);
    const bool is_gap_open =
        doing->axes().drawing(axis).is_servo && gap->gap_unit == 0 && is_feasible;
    if (is_gap_open) {
      WarnOfUnknownGap(axis, speed_unit_s, doing);
    }
  }
  doing->done().found.stop_feasible = all;
  return forecasts;
}

}  // namespace caltwin
