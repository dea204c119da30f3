#include "sim/effects/random_walk.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "sim/effects/homing_scatter.h"

namespace caltwin {
namespace {

// Sum of squares of n standard normal numbers, over n: 1 +- 4 standard deviations.
constexpr double FourSd(int n) {
  return 4 * 1.4142135623730951 / std::sqrt(n);
}

TEST(RandomWalk, BeginsAtZeroAndIsTheSameEveryTime) {
  EXPECT_EQ(BrownianPath(0), 0);
  EXPECT_EQ(BrownianPath(-5), 0);
  EXPECT_EQ(BrownianPath(1234.5), BrownianPath(1234.5));
}

TEST(RandomWalk, StandsStillBeyondItsHorizon) {
  const double horizon_s = SFromH(1024.0);

  EXPECT_EQ(BrownianPath(horizon_s), BrownianPath(2 * horizon_s));
  EXPECT_NEAR(BrownianPath(horizon_s * (1 - 1e-12)), BrownianPath(horizon_s), 1e-6);
}

// Steps of a Brownian path are independent, with the variance of their duration.
TEST(RandomWalk, StepsHaveTheVarianceOfTheirDurationAtEveryScale) {
  constexpr int kNumSteps = 1000;
  for (const double step_h : {0.001, 0.03, 1.0}) {
    double variance = 0, neighbours = 0, before = 0;
    for (int i = 0; i < kNumSteps; ++i) {
      const double step =
          BrownianPath(SFromH((i + 1) * step_h)) - BrownianPath(SFromH(i * step_h));
      variance += step * step / step_h / kNumSteps;
      neighbours += step * before / step_h / kNumSteps;
      before = step;
    }
    EXPECT_NEAR(variance, 1, FourSd(kNumSteps)) << step_h;
    EXPECT_NEAR(neighbours, 0, 4 / std::sqrt(kNumSteps)) << step_h;
  }
}

TEST(RandomWalk, IsContinuous) {
  // Within 1 ms at most a straight piece of 0.88 s rises by its thousandth.
  const double step_sqrt_h = std::sqrt(0.88 / SFromH(1.0));
  for (int i = 0; i < 1000; ++i) {
    const double t_s = 0.7371 * i;
    EXPECT_NEAR(BrownianPath(t_s), BrownianPath(t_s + 1e-3), 6 * step_sqrt_h / 800);
  }
}

TEST(HomingScatter, DeviatesAreStandardNormalOverHomings) {
  constexpr int kNumHomings = 2000;
  double mean = 0, variance = 0;
  for (int i = 0; i < kNumHomings; ++i) {
    const double deviate = HomingDeviate(std::to_string(i), "x");
    mean += deviate / kNumHomings;
    variance += deviate * deviate / kNumHomings;
  }

  EXPECT_NEAR(mean, 0, 4 / std::sqrt(kNumHomings));
  EXPECT_NEAR(variance, 1, FourSd(kNumHomings));
}

}  // namespace
}  // namespace caltwin
