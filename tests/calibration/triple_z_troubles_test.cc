#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/kinds/triple_z/troubles.h"
#include "sim/base/rng.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;
using Cause = OffPlane::Cause;

std::vector<BedTouch> Grid(int columns,
                           double sigma_mm,
                           std::uint64_t seed,
                           const std::function<double(double, double)>& shape) {
  Rng rng(seed, 0, "touches");
  std::vector<BedTouch> touches;
  for (int i = 0; i < columns; ++i) {
    for (int j = 0; j < columns; ++j) {
      const double x_mm = 20 + 200.0 * i / (columns - 1);
      const double y_mm = 20 + 200.0 * j / (columns - 1);
      touches.push_back({.at_mm = {x_mm, y_mm},
                         .height_mm = 0.004 * x_mm - 0.002 * y_mm + shape(x_mm, y_mm) +
                                      sigma_mm * rng.Normal()});
    }
  }
  return touches;
}

double Flat(double, double) {
  return 0;
}
double Bowl(double x_mm, double y_mm) {
  return 2e-5 * ((x_mm - 120) * (x_mm - 120) + (y_mm - 120) * (y_mm - 120));
}

// A tilted bed that is flat is called nothing, but for one in a hundred.
TEST(WhyOffPlane, AFlatBedIsCalledNothing) {
  int called = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    called += WhyOffPlane(Grid(3, 0.005, seed, Flat), 0.005) ? 1 : 0;
    called += WhyOffPlane(Grid(5, 0.005, seed, Flat), 0.005) ? 1 : 0;
  }

  EXPECT_LE(called, 8);
}

TEST(WhyOffPlane, ChipsUnderTheProbeAreOneTouch) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    auto touches = Grid(3, 0.005, seed, Flat);
    touches[5].height_mm += 0.3;

    const auto off = WhyOffPlane(touches, 0.005);

    ASSERT_TRUE(off);
    EXPECT_EQ(off->cause, Cause::kOneTouch);
    EXPECT_EQ(off->touch, 5u);
    EXPECT_NEAR(off->size_mm, 0.3, 0.05);
    EXPECT_THAT(off->words, HasSubstr("something lies on the bed"));
  }
}

TEST(WhyOffPlane, AHollowBedIsBent) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const auto off = WhyOffPlane(Grid(5, 0.005, seed, Bowl), 0.005);

    ASSERT_TRUE(off);
    EXPECT_EQ(off->cause, Cause::kBent) << off->words;
    EXPECT_NEAR(off->size_mm, 0.4, 0.03);  // 2e-5 * 2 * 100^2.
    EXPECT_THAT(off->words, HasSubstr("its middle low"));
  }
}

TEST(WhyOffPlane, TouchesThatDoNotRepeatHaveNoShape) {
  int scatter = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const auto off = WhyOffPlane(Grid(5, 0.1, seed, Flat), 0.005);
    scatter += off && off->cause == Cause::kScatter ? 1 : 0;
  }

  EXPECT_GE(scatter, 97);
}

TEST(WhyOffPlane, FewTouchesTellNoShape) {
  EXPECT_FALSE(WhyOffPlane(Grid(2, 0.1, 1, Flat), 0.005));
}

TEST(WhyNotLevel, ScrewsThatDidAsToldAreNoTrouble) {
  EXPECT_EQ(WhyNotLevel({0.8, 0, 1.3}, {0.801, -0.001, 1.298}, 0.002), "");
  EXPECT_EQ(WhyNotLevel({0, 0, 0}, {0.001, 0, 0}, 0.002), "");
}

TEST(WhyNotLevel, WhatTheScrewsDidIsNamed) {
  const Vec3<double> told(0.8, 0.1, 1.3);
  const auto words = [&](double z1, double z2, double z3) {
    return WhyNotLevel(told, {z1, z2, z3}, 0.002);
  };

  EXPECT_THAT(words(0, 0, 0), HasSubstr("did not move"));
  EXPECT_THAT(words(-0.8, -0.1, -1.3), HasSubstr("the other way"));
  EXPECT_THAT(words(0.8, 0.1, 0), HasSubstr("z3 did not move"));
  EXPECT_THAT(words(1.3, 0.1, 0.8), HasSubstr("z1 and z3 are exchanged"));
  EXPECT_THAT(words(0.1, 0.8, 1.3), HasSubstr("z1 and z2 are exchanged"));
  EXPECT_THAT(words(0.1, 1.3, 0.8), HasSubstr("in a ring"));
}

// Half the way fits no single cause, and none is named.
TEST(WhyNotLevel, WhatFitsNothingIsNotNamed) {
  EXPECT_EQ(WhyNotLevel({0.8, 0.1, 1.3}, {0.4, 0.05, 0.65}, 0.002), "");
}

// z1 and z2 were told the same: who is exchanged cannot show.
TEST(WhyNotLevel, WhatLooksAlikeIsNotToldApart) {
  EXPECT_EQ(WhyNotLevel({0.5, 0.5, 0}, {0.5, 0.5, 0}, 0.002), "");
}

}  // namespace
}  // namespace caltwin
