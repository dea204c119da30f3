#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "calibration/estimate/profile.h"

namespace caltwin {
namespace {

TEST(Profile, OfAParabolaIsBestPlusMinus196Sd) {
  const auto objective = [](double p) {
    return 12 + std::pow((p - 3) / 0.5, 2);
  };

  const ProfileInterval interval = ProfileOf(objective, 3, 0.5);

  EXPECT_TRUE(interval.is_closed);
  EXPECT_NEAR(interval.low, 3 - 1.959964 * 0.5, 1e-4);
  EXPECT_NEAR(interval.high, 3 + 1.959964 * 0.5, 1e-4);
}

TEST(Profile, OfAWrongFirstGuessOfTheSdIsTheSame) {
  const auto objective = [](double p) {
    return std::pow((p - 3) / 0.5, 2);
  };

  const ProfileInterval interval = ProfileOf(objective, 3, 0.1);

  EXPECT_NEAR(interval.high, 3 + 1.959964 * 0.5, 1e-3);
}

TEST(Profile, OfAPoissonMeanIsLopsided) {
  // -2 log L = 2 (mu - n log mu), n = 4: steeper towards 0 than away from it.
  const auto objective = [](double mu) {
    return mu > 0 ? 2 * (mu - 4 * std::log(mu)) : 1e9;
  };

  const ProfileInterval interval = ProfileOf(objective, 4, 2);

  EXPECT_NEAR(objective(interval.low) - objective(4), 3.841459, 1e-3);
  EXPECT_NEAR(objective(interval.high) - objective(4), 3.841459, 1e-3);
  EXPECT_LT(4 - interval.low, interval.high - 4);
}

TEST(Profile, WhatNothingTellsStaysOpen) {
  EXPECT_FALSE(ProfileOf([](double) { return 0.0; }, 0, 1).is_closed);
}

// NIST StRD, Misra1a: y = b1 (1 - exp(-b2 x)).
constexpr std::array<std::array<double, 2>, 14> kMisra1a = {{{10.07, 77.6},
                                                             {14.73, 114.9},
                                                             {17.94, 141.1},
                                                             {23.93, 190.8},
                                                             {29.61, 239.9},
                                                             {35.18, 289.0},
                                                             {40.02, 332.8},
                                                             {44.82, 378.4},
                                                             {50.76, 434.8},
                                                             {55.05, 477.3},
                                                             {61.01, 536.8},
                                                             {66.40, 593.1},
                                                             {75.47, 689.1},
                                                             {81.78, 760.0}}};
constexpr double kB2 = 5.5015643181e-04;
constexpr double kSdB2 = 7.2668688436e-06, kSquares = 1.2455138894e-01;

// Least squares over b1, which is linear, with b2 held.
double SquaresAt(double b2) {
  double xx = 0, xy = 0, yy = 0;
  for (const auto& [y, x] : kMisra1a) {
    const double shape = 1 - std::exp(-b2 * x);
    xx += shape * shape;
    xy += shape * y;
    yy += y * y;
  }
  return yy - xy * xy / xx;
}

TEST(Profile, OfMisra1aTouchesTheCertifiedFitAndItsStandardDeviation) {
  const double variance = kSquares / 12;
  const auto objective = [&](double b2) {
    return SquaresAt(b2) / variance;
  };

  const ProfileInterval interval = ProfileOf(objective, kB2, kSdB2);

  EXPECT_NEAR(SquaresAt(kB2), kSquares, 1e-9);
  // Misra1a bends little: its profile is 1.96 certified sd to 2 % either side.
  EXPECT_NEAR((kB2 - interval.low) / kSdB2, 1.96, 0.04);
  EXPECT_NEAR((interval.high - kB2) / kSdB2, 1.96, 0.04);
}

}  // namespace
}  // namespace caltwin
