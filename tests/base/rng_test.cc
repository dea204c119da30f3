#include "sim/base/rng.h"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "sim/base/distribution.h"

namespace caltwin {
namespace {

constexpr int kDraws = 20'000;

TEST(Rng, TheSameThreeGiveTheSameNumbers) {
  Rng a(7, 3, "backlash.x");
  Rng b(7, 3, "backlash.x");

  for (int i = 0; i < 100; ++i) EXPECT_EQ(a.Next(), b.Next());
}

TEST(Rng, AnotherSeedSampleOrUserIsAnotherStream) {
  std::set<std::uint64_t> firsts;
  for (std::uint64_t seed : {0, 1, 2}) {
    for (std::uint64_t sample : {0, 1, 2}) {
      for (const char* user : {"", "x", "y", "backlash.x"}) {
        firsts.insert(Rng(seed, sample, user).Next());
      }
    }
  }
  EXPECT_EQ(firsts.size(), 3u * 3u * 4u);
}

// Swapping seed and sample, or shifting one into the other, must not give one stream.
TEST(Rng, NeighbouringStreamsAreNotCorrelated) {
  double sum = 0;
  for (int i = 0; i < kDraws; ++i) {
    const auto sample = static_cast<std::uint64_t>(i);
    sum += Rng(1, sample, "x").Normal() * Rng(1, sample + 1, "x").Normal();
  }
  const double sigma = 1 / std::sqrt(kDraws);  // Of the mean of a product of normals.
  EXPECT_LT(std::abs(sum / kDraws), 4 * sigma);
}

TEST(Rng, UniformHasItsMeanAndVarianceAndNeverItsEnds) {
  Rng rng(1, 0, "uniform");
  double sum = 0, squares = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double u = rng.Uniform();
    ASSERT_GT(u, 0);
    ASSERT_LT(u, 1);
    sum += u - 0.5;
    squares += (u - 0.5) * (u - 0.5);
  }
  EXPECT_LT(std::abs(sum / kDraws), 4 * std::sqrt(1.0 / 12 / kDraws));
  // Variance of (u - 1/2)^2: 1/80 - 1/144.
  EXPECT_NEAR(
      squares / kDraws, 1.0 / 12, 4 * std::sqrt((1.0 / 80 - 1.0 / 144) / kDraws));
}

TEST(Rng, NormalHasTheMomentsOfANormal) {
  Rng rng(1, 0, "normal");
  double sum = 0, squares = 0, fourth = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double z = rng.Normal();
    sum += z;
    squares += z * z;
    fourth += z * z * z * z;
  }
  EXPECT_LT(std::abs(sum / kDraws), 4 * std::sqrt(1.0 / kDraws));
  EXPECT_NEAR(squares / kDraws, 1, 4 * std::sqrt(2.0 / kDraws));
  EXPECT_NEAR(fourth / kDraws, 3, 4 * std::sqrt(96.0 / kDraws));  // Var z^4 = 105 - 9.
}

TEST(Distribution, APlainNumberIsItselfAndDrawsNothing) {
  Rng rng(1, 0, "x"), untouched(1, 0, "x");

  EXPECT_EQ(Draw(0.05, &rng), 0.05);
  EXPECT_EQ(rng.Next(), untouched.Next());
}

TEST(Distribution, MiddleIsMeanMidRangeMedian) {
  EXPECT_EQ(Middle(3.0), 3);
  EXPECT_EQ(Middle(Normal{2, 5}), 2);
  EXPECT_EQ(Middle(Uniform{-1, 4}), 1.5);
  EXPECT_EQ(Middle(LogNormal{0.05, 2}), 0.05);
}

TEST(Distribution, DrawsHaveTheStatedSpread) {
  Rng rng(1, 0, "x");
  int inside_factor = 0, inside_sd = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double l = Draw(LogNormal{0.05, 2}, &rng);
    inside_factor += l > 0.025 && l < 0.1;
    inside_sd += std::abs(Draw(Normal{10, 3}, &rng) - 10) < 3;
    const double u = Draw(Uniform{2, 5}, &rng);
    ASSERT_TRUE(u > 2 && u < 5);
  }
  const double share = std::erf(1 / std::sqrt(2.0));  // 68.27 %
  const double sigma = std::sqrt(share * (1 - share) / kDraws);
  EXPECT_NEAR(inside_factor / static_cast<double>(kDraws), share, 4 * sigma);
  EXPECT_NEAR(inside_sd / static_cast<double>(kDraws), share, 4 * sigma);
}

TEST(Distribution, WhatLiesBeyondIsAsOftenAsItIsDrawn) {
  const Distribution all[] = {
      Normal{0.05, 0.03}, Uniform{-1, 3}, LogNormal{0.05, 2}, Normal{0.2, 0}};
  for (const Distribution& one : all) {
    Rng rng(1, 0, "x");
    int below = 0, above = 0;
    for (int i = 0; i < kDraws; ++i) {
      const double value = Draw(one, &rng);
      below += value < 0.02;
      above += value > 0.3;
    }
    const ShareBeyond beyond = Beyond(one, 0.02, 0.3);
    const auto near = [](int count, double share) {
      const double sd = std::sqrt(share * (1 - share) / kDraws);
      EXPECT_NEAR(count / static_cast<double>(kDraws), share, 4 * sd + 1e-12);
    };
    near(below, beyond.below);
    near(above, beyond.above);
  }
  // A number is no draw: whoever reads it refuses it where it lies beyond.
  EXPECT_EQ(Beyond(0.5, 0.02, 0.3).above, 0);
}

}  // namespace
}  // namespace caltwin
