#include <algorithm>
#include <cmath>
#include <numbers>

#include "calibration/kinds/motor_stage/procedures.h"

namespace caltwin {
namespace {

/// A motor that brakes with all its force, and a load behind a gap [units, s].
struct Braked {
  double inertia = 1;        ///< Of both, times si_per_unit: force over it is unit/s2.
  double motor_inertia = 1;  ///< Likewise.
  double force = 0;
  double friction = 0;  ///< On the load.
};

struct Standing {
  double at_s = 0;
  double coasts_s = 0;  ///< Of it the motor stands already, its load does not.
};

// From where the brake acts. As long as both move, their momentum goes by force and
// friction alone, whether they touch or not: v M / (F + f). Once the motor stands its
// force takes nothing off any more, until the load has crossed what is left of the gap.
Standing StandsAfter(const Braked& b, double speed_unit_s, double gap_unit) {
  const double together_unit_s2 = (b.force + b.friction) / b.inertia;
  const double load_inertia = b.inertia - b.motor_inertia;
  const double motor_unit_s2 = b.force / b.motor_inertia;
  const double load_unit_s2 = b.friction / load_inertia;
  const double motor_s = speed_unit_s / motor_unit_s2;
  const double ahead_unit =
      speed_unit_s * motor_s / 2 * (1 - load_unit_s2 / motor_unit_s2);
  const double left_unit = gap_unit - std::max(0.0, ahead_unit);
  if (left_unit <= 0 || load_unit_s2 >= motor_unit_s2) {
    return {.at_s = speed_unit_s / together_unit_s2};
  }
  const double load_unit_s = speed_unit_s - load_unit_s2 * motor_s;
  const double arrives_unit2_s2 =
      load_unit_s * load_unit_s - 2 * load_unit_s2 * left_unit;
  // Friction may stop it inside the gap.
  if (arrives_unit2_s2 <= 0) {
    const double at_s = speed_unit_s / load_unit_s2;
    return {.at_s = at_s, .coasts_s = at_s - motor_s};
  }
  const double arrives_unit_s = std::sqrt(arrives_unit2_s2);
  const double coasts_s = 2 * left_unit / (load_unit_s + arrives_unit_s);
  const double pushed_s = load_inertia * arrives_unit_s / (b.force + b.friction);
  return {.at_s = motor_s + coasts_s + pushed_s, .coasts_s = coasts_s};
}

// The highest speed that still stands in time, at most that without a gap: across one
// the slowest stand late as well.
double FastestInTime(const Braked& b, double gap_unit, double brake_s) {
  constexpr double kFiner = 0.995;
  constexpr int kSpeeds = 1000;  // Down to a hundredth.
  double speed_unit_s = brake_s * (b.force + b.friction) / b.inertia;
  for (int i = 0; i < kSpeeds; ++i, speed_unit_s *= kFiner) {
    constexpr double kRounding = 1 + 1e-9;
    if (StandsAfter(b, speed_unit_s, gap_unit).at_s <= brake_s * kRounding) {
      return speed_unit_s;
    }
  }
  return 0;
}

Braked BrakedBy(const MotorAxisDrawing& d, double heavier) {
  return {.inertia = heavier * d.total_inertia() * d.si_per_unit(),
          .motor_inertia = heavier * d.motor_inertia * d.si_per_unit(),
          .force = d.largest_force(),
          .friction = d.friction};
}

// The contact opens anywhere between two ticks.
double TickSd_s(const MotorBench& bench) {
  return bench.stop_tick_s / std::sqrt(12.0);
}

StopForecast ForecastServo(const MotorBench& bench,
                           const MotorAxisDrawing& d,
                           const StopAsked& asked) {
  const Braked usual = BrakedBy(d, 1), heavier = BrakedBy(d, 1 + bench.inertia_sigma);
  const Standing stands = StandsAfter(usual, asked.speed_unit_s, asked.gap_unit);
  const double by_inertia_s =
      StandsAfter(heavier, asked.speed_unit_s, asked.gap_unit).at_s - stands.at_s;
  const double by_gap_s =
      StandsAfter(usual, asked.speed_unit_s, asked.gap_unit + asked.gap_sd_unit).at_s -
      stands.at_s;
  const double brakes_s = asked.within_s - bench.BrakesAfter_s();
  return {.standstill_s = bench.BrakesAfter_s() + stands.at_s,
          .sd_s = std::hypot(by_inertia_s, by_gap_s, TickSd_s(bench)),
          .braked_s = stands.at_s,
          .braked_sd_s = std::hypot(by_inertia_s, by_gap_s),
          .path_unit = asked.speed_unit_s * (bench.BrakesAfter_s() + stands.at_s / 2),
          .fastest_unit_s = FastestInTime(usual, asked.gap_unit, brakes_s),
          .coasts_s = stands.coasts_s};
}

// What its field holds falls to half at the highest feed. Its rotor swings about the
// field when that stands; a quarter of the swing is what is not known of its
// standstill.
StopForecast ForecastStepper(const MotorBench& bench,
                             const MotorAxisDrawing& d,
                             const StopAsked& asked) {
  const double inertia = d.total_inertia() * d.si_per_unit();
  const double falls = d.largest_force() / (2 * d.max_velocity_unit_s);
  const double ramp_s = bench.stepper_stop_s;
  const double cycle_unit = 4 * d.lead_unit / d.full_steps_per_rev;
  const double swing_s =
      std::sqrt(2 * std::numbers::pi * inertia * cycle_unit / d.largest_force());
  StopForecast f{
      .standstill_s = bench.BrakesAfter_s() + ramp_s,
      .sd_s = std::hypot(swing_s / 4, TickSd_s(bench)),
      .path_unit = asked.speed_unit_s * (bench.BrakesAfter_s() + ramp_s / 2)};
  const double ramped = inertia / ramp_s;
  f.fastest_unit_s = (d.largest_force() + d.friction) / (ramped + falls);
  f.fastest_sd_unit_s =
      f.fastest_unit_s * bench.inertia_sigma * ramped / (ramped + falls);
  f.holds = asked.speed_unit_s <= f.fastest_unit_s;
  return f;
}

}  // namespace

StopForecast ForecastStop(const MotorBench& bench,
                          std::size_t axis,
                          const StopAsked& asked) {
  const MotorAxisDrawing& d = bench.drawing.axes[axis];
  return d.is_servo ? ForecastServo(bench, d, asked) : ForecastStepper(bench, d, asked);
}

}  // namespace caltwin
