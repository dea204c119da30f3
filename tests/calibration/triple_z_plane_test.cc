// A bed's slopes are as sure as they are said to be, whatever its touches scatter by.

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "calibration/kinds/triple_z/plane.h"
#include "calibration/procedures/scale_doubt.h"
#include "sim/base/rng.h"

namespace caltwin {
namespace {

constexpr double kStated_mm = 0.001;
constexpr int kBeds = 4000;

// How many of 4000 level beds' slopes lie within 1.96 sd, touched at nine points.
int Held(double scatter_mm, bool is_stated) {
  Rng rng(5, 0, "bed_plane");
  int held = 0;
  for (int bed = 0; bed < kBeds; ++bed) {
    std::vector<BedTouch> touches;
    for (const double x_mm : {0.0, 100.0, 200.0}) {
      for (const double y_mm : {0.0, 100.0, 200.0}) {
        touches.push_back({.at_mm = {x_mm, y_mm}});
        touches.back().height_mm = scatter_mm * rng.Normal();
      }
    }
    const BedPlane plane = FitBedPlane(touches, kStated_mm, is_stated);
    held += std::abs(plane.a()) <= 1.96 * plane.fit.slope_x.sd ? 1 : 0;
  }
  return held;
}

// Five standard deviations of a binomial count.
const double kChance = 5 * std::sqrt(0.95 * 0.05 * kBeds);

TEST(BedPlane, IntervalsHoldWhereTheStatedNoiseIsRight) {
  EXPECT_NEAR(Held(kStated_mm, true), 0.95 * kBeds, kChance);
}

TEST(BedPlane, IntervalsHoldWhereTouchesContradictTheStatedNoise) {
  EXPECT_NEAR(Held(10 * kStated_mm, true), 0.95 * kBeds, kChance);
}

TEST(BedPlane, IntervalsHoldWhereNobodyStatedANoise) {
  EXPECT_NEAR(Held(3 * kStated_mm, false), 0.95 * kBeds, kChance);
}

// Read in millimetres that are each 1 % too long or short.
TEST(WithScaleDoubt, IsTheFirstOrderOfBothScales) {
  const Uncertain slope{.value = 0.002, .sd = 3e-6, .identifiable = true};
  const Uncertain widened =
      WithScaleDoubt(slope, {.value = 1, .sd = 0.01}, {.value = 1, .sd = 0.02});

  const double along = 0.002 * 1.01 - 0.002, z = 0.002 * 1.02 - 0.002;
  EXPECT_EQ(widened.value, slope.value);
  EXPECT_NEAR(widened.sd, std::sqrt(9e-12 + along * along + z * z), 1e-12);
}

}  // namespace
}  // namespace caltwin
