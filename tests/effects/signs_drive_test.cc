// The signs of the drive's effects, each worked out by hand.
#include <cmath>

#include <gtest/gtest.h>

#include "sim/effects/predict.h"

namespace caltwin {
namespace {

constexpr double kExact = 1e-12;

// Travel 0 .. 300 on x and y, home at 0; z 0 .. 120, home at the top; lead 4 mm.
Machine Gantry() {
  Machine machine{.name = "test"};
  machine.axes[2].max_mm = 120;
  machine.axes[2].home = HomeEnd::kMax;
  machine.axes[2].counterbalance_n = machine.axes[2].moving_mass_kg * kGravity_m_s2;
  return machine;
}

std::vector<Injected> With(const char* effect,
                           const char* axis,
                           std::vector<double> values) {
  return {{.effect = *FindEffect(effect), .axis = axis, .values = std::move(values)}};
}

const Vec3<double> kX(1, 0, 0);
const Vec3<double> kZ(0, 0, 1);

// A gauge that reads the moving part along x, after a move in the sense given.
At Reading(double x_mm, double sense = 1) {
  return {.kind = RowKind::kPosition,
          .q_mm = {x_mm, 0, 0},
          .dir = {sense, 0, 0},
          .n = kX,
          .steps_per_mm = {800, 800, 800}};
}

double Value(const At& at, const std::vector<Injected>& effects) {
  return Predict_mm<double>(Gantry(), at, effects);
}

TEST(SignsOfDrives, AWaveIsASineOfTheCommandedPosition) {
  const auto wave = With("cyclic_lead", "x", {10, 0, 4});

  EXPECT_NEAR(Value(Reading(0), wave), 0, kExact);
  EXPECT_NEAR(Value(Reading(101), wave), +0.010, kExact);
  EXPECT_NEAR(Value(Reading(103), wave), -0.010, kExact);
}

TEST(SignsOfDrives, ThePhaseOfAWaveIsThatAtCommandedZero) {
  EXPECT_NEAR(Value(Reading(0), With("cyclic_lead", "x", {10, 90, 4})), +0.010, kExact);
  EXPECT_NEAR(
      Value(Reading(0), With("pulley_eccentric", "x", {10, -90, 40})), -0.010, kExact);
}

TEST(SignsOfDrives, AWaveSeenByATouchHasTheOtherSign) {
  At touch = Reading(101, -1);
  touch.kind = RowKind::kTouch;

  const double neutral_mm = Value(touch, {});
  EXPECT_NEAR(
      Value(touch, With("cyclic_lead", "x", {10, 0, 4})) - neutral_mm, -0.010, kExact);
}

TEST(SignsOfDrives, AWaveWhosePeriodIsLeftOutHasTheDrawnOne) {
  Injected wave = NeutralEffect(*FindEffect("cyclic_lead"), "x", Gantry());
  wave.values[0] = 10;

  EXPECT_NEAR(Value(Reading(1), {wave}), +0.010, kExact);  // A quarter of 4 mm.
}

TEST(SignsOfDrives, MicrostepsRepeatEveryFourFullSteps) {
  const auto ripple = With("microstep", "x", {3, 0});
  const double period_mm = 4 * 4.0 / 200;

  EXPECT_NEAR(Value(Reading(period_mm / 4), ripple), +0.003, kExact);
  EXPECT_NEAR(Value(Reading(100 * period_mm), ripple), 0, kExact);
}

TEST(SignsOfDrives, ABowToPlusMovesBothEndsToPlusAgainstTheMiddle) {
  const auto bow = With("pitch_progressive", "x", {30});

  const double middle_mm = Value(Reading(150), bow);
  EXPECT_NEAR(middle_mm, -0.010, kExact);
  EXPECT_NEAR(Value(Reading(0), bow) - middle_mm, +0.030, kExact);
  EXPECT_NEAR(Value(Reading(300), bow) - middle_mm, +0.030, kExact);
}

TEST(SignsOfDrives, AWornGapLagsByHalfOfWhatItIsWiderThere) {
  const auto worn = With("backlash_worn", "x", {0.08, 200, 60});

  EXPECT_NEAR(Value(Reading(200, +1), worn), -0.04, kExact);
  EXPECT_NEAR(Value(Reading(200, -1), worn), +0.04, kExact);
}

TEST(SignsOfDrives, AWornGapHasHalfItsExtraAtHalfItsWidth) {
  const auto worn = With("backlash_worn", "x", {0.08, 200, 60});

  EXPECT_NEAR(Value(Reading(170), worn), -0.02, kExact);
  EXPECT_NEAR(Value(Reading(230), worn), -0.02, kExact);
}

TEST(SignsOfDrives, AWeightKeepsAWornGapShutToo) {
  Machine machine = Gantry();
  machine.axes[2].counterbalance_n = 0;
  const At at{.kind = RowKind::kPosition,
              .q_mm = {0, 0, 60},
              .dir = {0, 0, 1},
              .n = kZ,
              .steps_per_mm = {800, 800, 800}};
  const auto worn = With("backlash_worn", "z", {0.08, 60, 60});

  EXPECT_NEAR(Predict_mm<double>(machine, at, worn), 0, kExact);
  EXPECT_NEAR(Predict_mm<double>(Gantry(), at, worn), -0.04, kExact);
}

TEST(SignsOfDrives, ASpikeLagsAfterTheReversalAndDiesAway) {
  const auto spike = With("reversal_spike", "x", {12, 0.5});
  At plus = Reading(100, +1), minus = Reading(100, -1);
  plus.since_rev_mm[0] = minus.since_rev_mm[0] = 0.5;

  EXPECT_NEAR(Value(plus, spike), -0.012 * std::exp(-1), kExact);
  EXPECT_NEAR(Value(minus, spike), +0.012 * std::exp(-1), kExact);
}

TEST(SignsOfDrives, ASpikeIsNotSeenWhereTheTravelSinceTheReversalIsUnknown) {
  EXPECT_NEAR(Value(Reading(100), With("reversal_spike", "x", {12, 0.5})), 0, kExact);
}

// Warmed by 10 K between 0 and 100 s, constant after.
Climate WarmedByTenKelvin() {
  Climate climate;
  for (TemperatureLog& log : climate.logs) {
    log.Add(0, 20);
    log.Add(100, 30);
  }
  return climate;
}

TEST(SignsOfDrives, AWarmScrewMovesTooFarFromItsHomeEnd) {
  const Climate climate = WarmedByTenKelvin();
  const auto steel_x = With("thermal_screw", "x", {11.5, 0});
  const auto steel_z = With("thermal_screw", "z", {11.5, 0});
  At x = Reading(200);
  x.t_s = 100;
  x.climate = &climate;
  At z = x;
  z.q_mm = {0, 0, 20};
  z.n = kZ;

  EXPECT_NEAR(Value(x, steel_x), +11.5e-6 * 200 * 10, kExact);
  EXPECT_NEAR(Value(z, steel_z), -11.5e-6 * 100 * 10, kExact);  // Home is at 120.
}

TEST(SignsOfDrives, AScrewThatLagsIsLessWarmThanItsThermometer) {
  const Climate climate = WarmedByTenKelvin();
  At at = Reading(100);
  at.t_s = 100;
  at.climate = &climate;

  // Behind a ramp of 0.1 K/s by 0.1 lag (1 - exp(-t / lag)).
  const double felt_k = 10 - 0.1 * 50 * (1 - std::exp(-2));
  EXPECT_NEAR(Value(at, With("thermal_screw", "x", {11.5, 50})),
              11.5e-6 * 100 * felt_k,
              kExact);
}

TEST(SignsOfDrives, WithoutThermometerNothingIsKnownToGrow) {
  EXPECT_NEAR(Value(Reading(100), With("thermal_screw", "x", {11.5, 0})), 0, kExact);
}

// Read at t, homed at the time given.
At Later(double t_s, double homed_at_s) {
  At at = Reading(100);
  at.t_s = t_s;
  at.homed_at_s = homed_at_s;
  return at;
}

TEST(SignsOfDrives, LostStepsMoveTheAxisToPlusUntilTheNextHoming) {
  const auto jump = With("missed_steps", "x", {80, 500});

  EXPECT_NEAR(Value(Later(499, 0), jump), 0, kExact);
  EXPECT_NEAR(Value(Later(500, 0), jump), +0.080, kExact);
  EXPECT_NEAR(Value(Later(900, 0), jump), +0.080, kExact);
  EXPECT_NEAR(Value(Later(900, 600), jump), 0, kExact);
}

TEST(SignsOfDrives, EachHomingHasOnePlaceAndEachAxisItsOwn) {
  const auto scatter = With("homing_scatter", "x", {10});
  At first = Reading(100), later = Reading(250);
  first.home = later.home = "7";
  At rehomed = first;
  rehomed.home = "8";

  EXPECT_NEAR(Value(first, scatter), 0.010 * HomingDeviate("7", "x"), kExact);
  EXPECT_EQ(Value(first, scatter), Value(later, scatter));
  EXPECT_NE(Value(first, scatter), Value(rehomed, scatter));
  EXPECT_NE(HomingDeviate("7", "x"), HomingDeviate("7", "y"));
}

}  // namespace
}  // namespace caltwin
