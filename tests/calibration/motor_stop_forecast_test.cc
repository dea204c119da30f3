#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "calibration/kinds/motor_stage/procedures.h"
#include "sim/base/rng.h"

namespace caltwin {
namespace {

// Motor and load, each moved by its own force in steps of 0.1 us until both stand. They
// meet without rebound; the brake holds a motor that stands, with all its force.
double StepUntilBothStand_s(const MotorAxisDrawing& d,
                            double speed_mm_s,
                            double gap_mm) {
  constexpr double kStep_s = 1e-7, kMm = 1e3;
  double motor_mm_s = speed_mm_s, load_mm_s = speed_mm_s, ahead_mm = 0;
  int steps = 0;
  for (; (motor_mm_s > 0 || load_mm_s > 0) && steps < 2'000'000; ++steps) {
    if (ahead_mm >= gap_mm) {
      const double shared_mm_s =
          (motor_mm_s * d.motor_inertia + load_mm_s * d.load_inertia) /
          d.total_inertia();
      const double slows_mm_s =
          kMm * (d.largest_force() + d.friction) / d.total_inertia() * kStep_s;
      motor_mm_s = load_mm_s = std::max(0.0, shared_mm_s - slows_mm_s);
      continue;
    }
    motor_mm_s =
        std::max(0.0, motor_mm_s - kMm * d.largest_force() / d.motor_inertia * kStep_s);
    load_mm_s = std::max(0.0, load_mm_s - kMm * d.friction / d.load_inertia * kStep_s);
    ahead_mm += (load_mm_s - motor_mm_s) * kStep_s;
  }
  return steps * kStep_s;
}

TEST(ForecastStop, AcrossAGapIsWhatTwoMassesDo) {
  Rng rng(11, 0, "two_masses");
  int waits = 0;
  for (int i = 0; i < 60; ++i) {
    MotorBench bench;
    MotorAxisDrawing& x = bench.drawing.axes[0];
    x.load_inertia = 2 * std::pow(30, rng.Uniform());
    x.motor_inertia = x.load_inertia * (0.7 + 3 * rng.Uniform());
    x.friction = 5 + 35 * rng.Uniform();
    const double speed_mm_s = 5 * std::pow(100, rng.Uniform());
    const double gap_mm = 0.01 * std::pow(20, rng.Uniform());

    const StopForecast f =
        ForecastStop(bench, 0, {.speed_unit_s = speed_mm_s, .gap_unit = gap_mm});

    const double expected_s =
        bench.BrakesAfter_s() + StepUntilBothStand_s(x, speed_mm_s, gap_mm);
    // A step at each of four events, and what an impact late by one makes of it.
    EXPECT_NEAR(f.standstill_s, expected_s, 2e-6 + 1e-4 * expected_s) << i;
    waits += f.coasts_s > 0 ? 1 : 0;
  }
  EXPECT_GT(waits, 15);
  EXPECT_LT(waits, 55);
}

// Without a gap v M / (F + f), and never sooner with one.
TEST(ForecastStop, IsLaterTheWiderTheGap) {
  MotorBench bench;
  const MotorAxisDrawing& x = bench.drawing.axes[0];
  double before_s = 0;
  for (const double gap_mm : {0.0, 0.001, 0.01, 0.05, 0.1, 0.2, 0.5}) {
    const StopForecast f =
        ForecastStop(bench, 0, {.speed_unit_s = 40, .gap_unit = gap_mm});
    if (gap_mm == 0) {
      EXPECT_DOUBLE_EQ(f.standstill_s,
                       bench.BrakesAfter_s() + 0.040 * x.total_inertia() /
                                                   (x.largest_force() + x.friction));
    }
    EXPECT_GE(f.standstill_s, before_s) << gap_mm;
    before_s = f.standstill_s;
  }
}

// At the speed that it says still stands in time, it does; a little faster it does not.
TEST(ForecastStop, TellsTheSpeedThatStandsInTime) {
  MotorBench bench;
  for (const double gap_mm : {0.0, 0.1}) {
    const auto stands_s = [&](double speed_mm_s) {
      return ForecastStop(bench, 0, {.speed_unit_s = speed_mm_s, .gap_unit = gap_mm})
          .standstill_s;
    };
    const double fastest_mm_s =
        ForecastStop(bench, 0, {.speed_unit_s = 1, .gap_unit = gap_mm}).fastest_unit_s;

    EXPECT_LE(stands_s(fastest_mm_s), 0.005 + 1e-9) << gap_mm;
    EXPECT_GT(stands_s(1.006 * fastest_mm_s), 0.005) << gap_mm;
  }
}

// H (1 - v / 2 v_max) = v M / t_ramp - f where its field just holds.
TEST(ForecastStop, OfAStepperHoldsUpToASpeedThatItsInertiaLeavesOpen) {
  MotorBench bench;
  MotorAxisDrawing& u = bench.drawing.axes[4];
  u = {.is_servo = false,
       .lead_unit = 8,
       .max_velocity_unit_s = 60,
       .motor_inertia = 2,
       .load_inertia = 41.5,
       .friction = 5,
       .force_per_amp = 100,
       .current_limit_a = 2};

  const StopForecast f = ForecastStop(bench, 4, {.speed_unit_s = 30});

  const double v = f.fastest_unit_s;
  EXPECT_NEAR(200 * (1 - v / 120), 43.5 * v * 1e-3 / 0.004 - 5, 1e-6);
  EXPECT_FALSE(f.holds);
  bench.drawing.axes[4].load_inertia += 43.5 * 0.0001;
  const double heavier = ForecastStop(bench, 4, {.speed_unit_s = 30}).fastest_unit_s;
  EXPECT_NEAR(f.fastest_sd_unit_s, 300 * (v - heavier), 1e-3);
  // A quarter of 2 pi sqrt(M / k), k = 200 N 2 pi / 0.16 mm.
  const double stiffness = 200 * 2 * std::numbers::pi / 0.16e-3;
  const double swing_s = std::numbers::pi / 2 * std::sqrt(43.5 / stiffness);
  EXPECT_NEAR(f.sd_s, std::hypot(swing_s, bench.stop_tick_s / std::sqrt(12.0)), 1e-9);
}

}  // namespace
}  // namespace caltwin
