#include <cmath>

#include <gtest/gtest.h>

#include "calibration/estimate/f_test.h"

namespace caltwin {
namespace {

// With two degrees of freedom on either side the tail has a closed form.
TEST(FUpperTail, IsItsClosedFormWithTwoDegreesOfFreedom) {
  for (const double f : {0.0, 0.3, 1.0, 7.5, 400.0}) {
    for (const double d : {1.0, 4.0, 37.0, 250.0}) {
      const double above = std::pow(d / (d + 2 * f), d / 2);
      EXPECT_NEAR(FUpperTail(f, 2, d), above, 1e-12 + 1e-10 * above) << f << " " << d;
      EXPECT_NEAR(FUpperTail(f, d, 2), 1 - std::pow(d * f / (d * f + 2), d / 2), 1e-12)
          << f << " " << d;
    }
  }
}

// Of the tables: 95 and 99 % points.
TEST(FUpperTail, HasThePointsOfTheTables) {
  EXPECT_NEAR(FUpperTail(3.3258, 5, 10), 0.05, 1e-5);
  EXPECT_NEAR(FUpperTail(2.9782, 10, 10), 0.05, 1e-5);
  EXPECT_NEAR(FUpperTail(4.8491, 10, 10), 0.01, 1e-5);
  EXPECT_NEAR(FUpperTail(161.4476, 1, 1), 0.05, 1e-5);
}

// Either variance may stand above.
TEST(FUpperTail, TurnsRoundWithItsVariances) {
  EXPECT_NEAR(FUpperTail(1.7, 12, 31) + FUpperTail(1 / 1.7, 31, 12), 1, 1e-12);
}

}  // namespace
}  // namespace caltwin
