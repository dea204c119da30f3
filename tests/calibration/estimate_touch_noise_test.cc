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

}  // namespace
}  // namespace caltwin
