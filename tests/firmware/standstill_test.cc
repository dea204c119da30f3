#include "sim/firmware/standstill.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "sim/base/rng.h"

namespace caltwin {
namespace {

constexpr double kTick_s = 0.00025;

// Whole pulses of a motor that is braked evenly from tick 0 on, and of its rest.
std::vector<std::int64_t> CountsOf(double speed_pulses_s,
                                   double at_s,
                                   double first_pulses) {
  std::vector<std::int64_t> counts;
  for (int tick = 0; tick * kTick_s < at_s + 0.002; ++tick) {
    const double t_s = std::min(tick * kTick_s, at_s);
    counts.push_back(static_cast<std::int64_t>(
        std::floor(first_pulses + speed_pulses_s * (t_s - t_s * t_s / (2 * at_s)))));
  }
  return counts;
}

// Either sense, any part of a pulse, 40 to 4000 pulses to a standstill.
TEST(StandstillOf, RecoversAnEvenBrakeWithItsUncertainty) {
  constexpr int kStops = 400;
  Rng rng(3, 0, "standstill");
  double squares = 0, smallest_s = 1, largest_s = 0;
  for (int i = 0; i < kStops; ++i) {
    const double at_s = 0.002 + 0.006 * rng.Uniform();
    const double way_pulses = 40 * std::pow(100, rng.Uniform());
    const double speed_pulses_s = (i % 2 == 0 ? 2 : -2) * way_pulses / at_s;
    const auto counts = CountsOf(speed_pulses_s, at_s, 10 * rng.Uniform());

    const Standstill stood = StandstillOf(counts, kTick_s, speed_pulses_s);

    squares += std::pow((stood.at_s - at_s) / stood.sd_s, 2);
    smallest_s = std::min(smallest_s, stood.sd_s);
    largest_s = std::max(largest_s, stood.sd_s);
  }

  // Chi-squared of 400, four of its standard deviations.
  EXPECT_NEAR(squares, kStops, 4 * std::sqrt(2.0 * kStops));
  EXPECT_LT(largest_s, 0.0001);
  EXPECT_LT(smallest_s, 0.000001);
}

// A motor that is held at 0.7 ms and pushed on by its carriage at 3 ms.
TEST(StandstillOf, WithoutAnEvenBrakeIsWhenTheCounterCameToRest) {
  std::vector<std::int64_t> counts = {
      0, 40, 60, 60, 60, 60, 60, 60, 60, 60, 60, 60, 80, 95, 100};
  counts.insert(counts.end(), 10, 101);

  const Standstill stood = StandstillOf(counts, kTick_s, 160'000);

  EXPECT_DOUBLE_EQ(stood.at_s, 14 * kTick_s);
  EXPECT_DOUBLE_EQ(stood.sd_s, kTick_s);
}

// Rattling with its load at two pulses a tick, after 100 a tick: it stands, and creeps.
TEST(StandstillOf, CreepingIsNoMovingAnyMore) {
  std::vector<std::int64_t> counts = {0, 100, 190, 240, 300, 310, 360, 380};
  for (int tick = 0; tick < 20; ++tick) counts.push_back(counts.back() + 2);
  counts.insert(counts.end(), 20, counts.back());

  const Standstill stood = StandstillOf(counts, kTick_s, 100 / kTick_s);

  EXPECT_DOUBLE_EQ(stood.at_s, 8 * kTick_s);
  EXPECT_DOUBLE_EQ(stood.rests_at_s, 27 * kTick_s);
}

// Braked, pushed on by a load that comes across its gap, braked again: what counts are
// those after it, whose speed nobody told.
TEST(StandstillOf, AfterAKnockIsThatOfTheLastRunWithItsUncertainty) {
  constexpr int kStops = 300;
  Rng rng(4, 0, "knocked");
  double squares = 0;
  int knocked = 0;
  for (int i = 0; i < kStops; ++i) {
    const double sense = i % 2 == 0 ? 1 : -1;
    const double knock_s = 0.001 + 0.002 * rng.Uniform();
    const double pushed_s = 0.002 + 0.003 * rng.Uniform();
    const double way_pulses = 30 * std::pow(30, rng.Uniform());
    const double before_pulses_s = 3 * way_pulses / pushed_s;
    const double first_pulses = 10 * rng.Uniform();
    std::vector<std::int64_t> counts;
    for (int tick = 0; tick < 80; ++tick) {
      const double t_s = tick * kTick_s;
      const double braked_s = std::min(t_s, knock_s);
      const double u = std::clamp(t_s - knock_s, 0.0, pushed_s) / pushed_s;
      const double gone = before_pulses_s * braked_s * (1 - braked_s / knock_s / 2.5) +
                          way_pulses * (2 * u - u * u);
      counts.push_back(
          static_cast<std::int64_t>(std::floor(first_pulses + sense * gone)));
    }

    const Standstill stood = StandstillOf(counts, kTick_s, sense * before_pulses_s);

    squares += std::pow((stood.at_s - knock_s - pushed_s) / stood.sd_s, 2);
    knocked += stood.is_knocked ? 1 : 0;
    EXPECT_LE(stood.sd_s, kTick_s);
  }

  // Chi-squared of 300, four of its standard deviations.
  EXPECT_LT(squares, kStops + 4 * std::sqrt(2.0 * kStops));
  // One in a hundred may be a parabola to a pulse by chance.
  EXPECT_GE(knocked, 0.99 * kStops);
}

TEST(StandstillOf, WhatWasNotMovedStands) {
  EXPECT_EQ(StandstillOf(std::vector<std::int64_t>(20, 7), kTick_s, 0).at_s, 0);
}

}  // namespace
}  // namespace caltwin
