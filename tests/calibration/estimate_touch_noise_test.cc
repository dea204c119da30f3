#include <array>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "calibration/estimate/touch_noise.h"
#include "sim/base/rng.h"

namespace caltwin {
namespace {

TEST(TouchNoise, OneTouchHasItsScatterAndATwelfthOfTheStep) {
  EXPECT_NEAR(TouchSd_mm({.sigma_mm = 0.003, .step_mm = 0}), 0.003, 1e-15);
  EXPECT_NEAR(
      TouchSd_mm({.sigma_mm = 0, .step_mm = 0.012}), 0.012 / std::sqrt(12), 1e-15);
}

TEST(TouchNoise, ScatterAveragesOutOverRepeats) {
  EXPECT_NEAR(MeanSd_mm({.sigma_mm = 0.004, .step_mm = 0}, 16), 0.001, 1e-15);
}

TEST(TouchNoise, RoundingDoesNotAverageOutWithoutScatter) {
  const TouchNoise noise{.sigma_mm = 0, .step_mm = 0.00125};

  EXPECT_NEAR(MeanSd_mm(noise, 100), 0.00125 / std::sqrt(12), 1e-15);
}

TEST(TouchNoise, RoundingAveragesOutWhereScatterShakesIt) {
  const TouchNoise noise{.sigma_mm = 0.0025, .step_mm = 0.00125};

  EXPECT_NEAR(MeanSd_mm(noise, 100), TouchSd_mm(noise) / 10, 1e-12);
}

// The formula between the two ends, against rounding itself: means of n rounded
// readings at random places between two steps.
TEST(TouchNoise, MeanOfRoundedReadingsScattersAsStated) {
  constexpr int kTrials = 4000;
  constexpr int kTouches = 10;
  constexpr TouchNoise kNoise{.sigma_mm = 0.2, .step_mm = 1};
  Rng rng(3, 0, "touch_noise");
  double squares = 0;

  for (int trial = 0; trial < kTrials; ++trial) {
    const double place_mm = rng.Uniform();
    double error_mm = 0;
    for (int touch = 0; touch < kTouches; ++touch) {
      error_mm += std::round(place_mm + kNoise.sigma_mm * rng.Normal()) - place_mm;
    }
    squares += std::pow(error_mm / kTouches, 2);
  }

  const double stated = std::pow(MeanSd_mm(kNoise, kTouches), 2);
  EXPECT_NEAR(squares / kTrials / stated, 1, 4 * std::sqrt(2.0 / kTrials));
}

TEST(TouchNoise, ScatterIsTheSampleStandardDeviation) {
  EXPECT_DOUBLE_EQ(Scatter(std::array{2.0, 4.0, 6.0}), 2.0);
  EXPECT_DOUBLE_EQ(Scatter(std::array{2.0}), 0.0);
}

TEST(TouchNoise, TriggerScatterPoolsGroupsAboutTheirOwnMeans) {
  const std::array first{10.0, 12.0};      // variance 2, one degree of freedom
  const std::array second{5.0, 5.0, 5.0};  // none, two

  const Uncertain scatter =
      TriggerScatter_mm(std::array<std::span<const double>, 2>{first, second}, 0);

  EXPECT_TRUE(scatter.identifiable);
  EXPECT_DOUBLE_EQ(scatter.value, std::sqrt(2.0 / 3));
}

TEST(TouchNoise, ScatterOfSingleTouchesIsNotIdentifiable) {
  const std::array single{1.0};

  EXPECT_FALSE(TriggerScatter_mm(std::array<std::span<const double>, 1>{single}, 0)
                   .identifiable);
  EXPECT_FALSE(MeanTouch_mm({}, {.sigma_mm = 1}).identifiable);
}

// Of Student's t, as tabulated: 12.706 for one degree of freedom, 2.262 for nine.
TEST(NoiseSeen, SmallSamplesAreWidenedByStudent) {
  constexpr double kPrinted = 5e-4 / 1.96;

  EXPECT_NEAR(SmallSampleFactor(1), 12.706 / 1.959964, kPrinted);
  EXPECT_NEAR(SmallSampleFactor(9), 2.262 / 1.959964, kPrinted);
  EXPECT_NEAR(SmallSampleFactor(1000), 1, 2e-3);
}

// Groups of ten touches that scatter by `sigma`, read to the micrometre's fraction.
std::vector<std::vector<double>> Groups(double sigma_mm, int groups, Rng* rng) {
  std::vector<std::vector<double>> all(static_cast<std::size_t>(groups));
  for (auto& group : all) {
    for (int i = 0; i < 10; ++i) group.push_back(sigma_mm * rng->Normal());
  }
  return all;
}

TouchNoise Seen(const TouchNoise& stated, const std::vector<std::vector<double>>& all) {
  const std::vector<std::span<const double>> groups(all.begin(), all.end());
  return NoiseSeen(stated, groups);
}

TEST(NoiseSeen, WhatIsStatedStandsButOnceInAThousand) {
  constexpr int kTrials = 20'000;
  constexpr TouchNoise kStated{.sigma_mm = 0.001};
  Rng rng(1, 0, "noise_seen");
  int contradicted = 0;

  for (int trial = 0; trial < kTrials; ++trial) {
    const TouchNoise seen = Seen(kStated, Groups(0.001, 2, &rng));
    contradicted += seen.sigma_mm == kStated.sigma_mm ? 0 : 1;
  }

  const double expected = 0.001 * kTrials;
  EXPECT_NEAR(contradicted, expected, 5 * std::sqrt(expected));
}

TEST(NoiseSeen, TwiceTheStatedScatterIsSeen) {
  Rng rng(2, 0, "noise_seen");
  const auto groups = Groups(0.002, 4, &rng);

  const TouchNoise seen = Seen({.sigma_mm = 0.001}, groups);

  // 36 degrees of freedom tell a standard deviation to 12 %.
  EXPECT_NEAR(seen.sigma_mm, 0.002, 4 * 0.12 * 0.002);
}

TEST(NoiseSeen, RepeatsOnOneStepTellNothing) {
  const TouchNoise stated{.sigma_mm = 0.0001, .step_mm = 0.00125};

  EXPECT_EQ(Seen(stated, {{1, 1, 1}, {2, 2}}).sigma_mm, stated.sigma_mm);
  EXPECT_EQ(Seen(stated, {{1}}).sigma_mm, stated.sigma_mm);
}

// Nobody stated anything: intervals of 1.96 sd of a mean of three hold 95 %.
TEST(NoiseSeen, IntervalsHoldWithoutAStatement) {
  constexpr int kTrials = 10'000;
  Rng rng(3, 0, "noise_seen");
  int held = 0;

  for (int trial = 0; trial < kTrials; ++trial) {
    const std::vector<double> touches{rng.Normal(), rng.Normal(), rng.Normal()};
    const Uncertain mean = MeanTouch_mm(touches, Seen({}, {touches}));
    held += std::abs(mean.value) <= 1.96 * mean.sd ? 1 : 0;
  }

  EXPECT_NEAR(held, 0.95 * kTrials, 5 * std::sqrt(0.95 * 0.05 * kTrials));
}

// +-1.96 of its own sd about a sample standard deviation hold the true one.
TEST(ScatterSdFactor, IntervalsHoldTheTrueScatter) {
  constexpr int kTrials = 10'000;
  for (const int count : {5, 20}) {
    Rng rng(4, 0, "scatter_sd");
    int held = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
      std::vector<double> readings(static_cast<std::size_t>(count));
      for (double& reading : readings) reading = rng.Normal();
      const double seen = Scatter(readings);
      held += std::abs(seen - 1) <= 1.96 * ScatterSdFactor(count - 1) * seen ? 1 : 0;
    }
    // Wilson and Hilferty's chi2 is right to 0.3 % there.
    const double chance = 5 * std::sqrt(0.95 * 0.05 * kTrials);
    EXPECT_NEAR(held, 0.95 * kTrials, chance + 0.003 * kTrials) << count;
  }
}

TEST(ScatterSdFactor, OfManyReadingsIsTheUsualOne) {
  EXPECT_NEAR(ScatterSdFactor(20'000), 1 / std::sqrt(2.0 * 20'000), 1e-5);
}

TEST(ScatterFactor, OnlyContradictionTakesThePlaceOfWhatWasStated) {
  EXPECT_EQ(ScatterFactor(2, 6), 1);
  EXPECT_NEAR(ScatterFactor(9, 6), 3 * SmallSampleFactor(6), 1e-12);
  EXPECT_EQ(ScatterFactor(9, 0), 1);
  EXPECT_NEAR(ScatterFactor(2, 6, false), std::sqrt(2) * SmallSampleFactor(6), 1e-12);
  EXPECT_EQ(ScatterFactor(0.01, 6, false), 1);
}

}  // namespace
}  // namespace caltwin
