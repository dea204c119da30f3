// Sums and quantiles that do not depend on order, and the normals that fill them.

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "sim/base/exact_sum.h"
#include "sim/base/normals.h"
#include "sim/base/quantile_sketch.h"

namespace caltwin {
namespace {

TEST(ExactSum, KeepsWhatRoundingWouldLose) {
  ExactSum sum;
  for (const double part : {1e300, 1.0, -1e300, 1e-300, -1.0}) sum.Add(part);

  EXPECT_EQ(sum.Value(), 1e-300);
}

TEST(ExactSum, IsTheSameInAnyOrderAndDivision) {
  Rng rng(1, 0, "exact_sum");
  std::vector<double> values;
  for (int i = 0; i < 1000; ++i) {
    values.push_back(std::ldexp(rng.Normal(), static_cast<int>(40 * rng.Normal())));
  }
  ExactSum forward, one, other;
  for (std::size_t i = 0; i < values.size(); ++i) {
    forward.Add(values[i]);
    (i % 3 == 0 ? one : other).Add(values[values.size() - 1 - i]);
  }
  one.Add(other);

  EXPECT_EQ(one.Value(), forward.Value());
}

TEST(ExactSum, IsKeptWithoutLoss) {
  for (const double value : {-1.0, 0.0, 1e300, -5e-324}) {
    ExactSum sum;
    sum.Add(value);
    sum.Add(0.1);
    auto again = ExactSum::OfLimbs(sum.Limbs());
    ASSERT_TRUE(again);
    EXPECT_EQ(again->Limbs(), sum.Limbs());
    again->Add(-0.1);
    EXPECT_EQ(again->Value(), value);
  }
  std::vector<std::int64_t> limbs(ExactSum::kLimbs);
  limbs[3] = -1;
  EXPECT_FALSE(ExactSum::OfLimbs(limbs));
  limbs.pop_back();
  EXPECT_FALSE(ExactSum::OfLimbs(limbs));
}

// Halves, quarters ... sum up exactly in doubles too.
TEST(ExactSum, AgreesWithDoublesWhereTheyAreExact) {
  ExactSum sum;
  double plain = 0;
  for (int i = -20; i < 20; ++i) {
    const double value = std::ldexp(i % 3 == 0 ? -1 : 1, i);
    sum.Add(value);
    plain += value;
  }

  EXPECT_EQ(sum.Value(), plain);
  EXPECT_EQ(ExactSum().Value(), 0);
  ExactSum denormal;
  denormal.Add(5e-324);
  EXPECT_EQ(denormal.Value(), 5e-324);
}

TEST(QuantileSketch, HasTheQuantilesToItsResolution) {
  Rng rng(2, 0, "sketch");
  QuantileSketch sketch;
  std::vector<double> values;
  for (int i = 0; i < 20'000; ++i) {
    values.push_back(1e-3 * rng.Normal());
    sketch.Add(values.back());
  }
  std::ranges::sort(values);

  for (const double p : {0.001, 0.025, 0.16, 0.84, 0.975, 0.999}) {
    const double exact = values[static_cast<std::size_t>(p * 20'000)];
    // Half a part, and the neighbouring order statistics in the tails.
    EXPECT_NEAR(sketch.Quantile(p), exact, std::abs(exact) / 50) << p;
  }
  EXPECT_EQ(sketch.count(), 20'000);
}

TEST(QuantileSketch, PartsAddUpToTheWhole) {
  QuantileSketch whole, one, other;
  for (const double value : {-3.0, -1e-20, 0.0, 0.5, 7.0, 1e30}) {
    whole.Add(value);
    (value < 0.2 ? one : other).Add(value);
  }
  one.Add(other);

  EXPECT_EQ(one.count(), 6);
  EXPECT_EQ(one.Quantile(0.5), whole.Quantile(0.5));
  EXPECT_EQ(QuantileSketch().Quantile(0.5), 0);
  EXPECT_LT(one.Parts().front().low, -2.9);
  EXPECT_GT(one.Parts().back().high, 1e7);
}

TEST(QuantileSketch, IsKeptWithoutLoss) {
  QuantileSketch sketch;
  for (const double value : {-3.0, 0.0, 0.5, 0.5, 1e30}) sketch.Add(value);
  const auto again = QuantileSketch::OfCounts(sketch.Counts());

  ASSERT_TRUE(again);
  EXPECT_EQ(again->Counts(), sketch.Counts());
  EXPECT_EQ(again->count(), 5);
  EXPECT_FALSE(QuantileSketch::OfCounts({{-1, 1}}));
  EXPECT_FALSE(QuantileSketch::OfCounts({{1'000'000, 1}}));
  EXPECT_FALSE(QuantileSketch::OfCounts({{7, 0}}));
}

// Moments and tails of the standard normal distribution; five standard errors.
TEST(QuickNormal, IsNormal) {
  constexpr int kDraws = 400'000;
  Rng rng(3, 0, "quick_normal");
  double sum = 0, squares = 0, fourths = 0;
  int beyond_3 = 0, beyond_last_layer = 0, inside = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double x = QuickNormal(&rng);
    sum += x;
    squares += x * x;
    fourths += x * x * x * x;
    beyond_3 += std::abs(x) > 3 ? 1 : 0;
    beyond_last_layer += std::abs(x) > 3.442619855899 ? 1 : 0;
    inside += std::abs(x) < 0.6744897501960817 ? 1 : 0;  // The quartiles.
  }
  const auto chance = [](double p) {
    return 5 * std::sqrt(p * (1 - p) * kDraws);
  };

  EXPECT_NEAR(sum / kDraws, 0, 5 / std::sqrt(kDraws));
  EXPECT_NEAR(squares / kDraws, 1, 5 * std::sqrt(2.0 / kDraws));
  EXPECT_NEAR(fourths / kDraws, 3, 5 * std::sqrt(96.0 / kDraws));
  EXPECT_NEAR(beyond_3, 0.0026998 * kDraws, chance(0.0027));
  EXPECT_NEAR(beyond_last_layer, 0.00057600 * kDraws, chance(0.000576));
  EXPECT_NEAR(inside, 0.5 * kDraws, chance(0.5));
}

}  // namespace
}  // namespace caltwin
