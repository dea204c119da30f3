// When enough trials are enough, what the first-order result is worth, and where errors
// come from.

#include <cmath>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenarios/study/adaptive.h"
#include "scenarios/study/budget.h"
#include "scenarios/study/summary.h"
#include "sim/base/rng.h"
#include "tests/base/temp_folder.h"

namespace caltwin {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

// JCGM 101 7.9.2.1, examples: u = 0.35 g and 0.39 C with two digits; and its rounding.
TEST(NumericalTolerance, IsHalfOfTheLastDigitOfU) {
  EXPECT_DOUBLE_EQ(NumericalTolerance(0.000'2, 1), 0.000'05);
  EXPECT_DOUBLE_EQ(NumericalTolerance(0.35, 2), 0.005);
  EXPECT_DOUBLE_EQ(NumericalTolerance(0.35, 1), 0.05);
  EXPECT_DOUBLE_EQ(NumericalTolerance(9.96, 2), 0.5);  // 10, not 9.9.
  EXPECT_EQ(NumericalTolerance(0, 2), 0);
}

std::vector<double> Batch(double sd, int size, Rng* rng) {
  std::vector<double> values;
  for (int i = 0; i < size; ++i) values.push_back(sd * rng->Normal());
  return values;
}

TEST(AdaptiveStop, NeedsTwoBatchesAndThatTheyAgree) {
  Rng rng(1, 0, "adaptive");
  AdaptiveStop stop(1);
  EXPECT_FALSE(stop.IsSettled());
  stop.AddBatch({{"gap", Batch(0.35, 10'000, &rng)}});
  EXPECT_FALSE(stop.IsSettled());
  stop.AddBatch({{"gap", Batch(0.35, 10'000, &rng)}});

  // Ends of 10^4 values scatter by 0.0094, far below the tolerance of 0.05.
  EXPECT_TRUE(stop.IsSettled());
  const Settling gap = stop.State().at("gap");
  EXPECT_EQ(gap.delta, 0.05);
  EXPECT_NEAR(gap.u, 0.35, 5 * 0.35 / std::sqrt(40'000));
  EXPECT_NEAR(gap.high, 1.96 * 0.35, 5 * 2.671 * 0.35 / std::sqrt(20'000));
}

TEST(AdaptiveStop, MoreDigitsTakeMoreBatches) {
  Rng rng(2, 0, "adaptive");
  AdaptiveStop one(1), two(2);
  int batches_for_one = 0, batches_for_two = 0;
  for (int batch = 1; batch <= 60 && !two.IsSettled(); ++batch) {
    const std::map<std::string, std::vector<double>> values = {
        {"gap", Batch(0.35, 2'000, &rng)}};
    if (!one.IsSettled()) {
      one.AddBatch(values);
      batches_for_one = batch;
    }
    two.AddBatch(values);
    batches_for_two = batch;
  }
  // Twice 2.671 * 0.35 / sqrt(2000 h) falls below 0.005 at about h = 70, chance apart.
  EXPECT_LT(batches_for_one, 6);
  EXPECT_GT(batches_for_two, 20);
}

TEST(ValidationOf, HoldsWhereTheStatedIntervalIsTheOneSeen) {
  const Quantiles seen{.count = 1'000'000,
                       .mean = 0,
                       .sd = 0.35,
                       .q025 = -0.686,
                       .median = 0,
                       .q975 = 0.69};
  const Validation honest = ValidationOf(seen, 0.35, 1);
  EXPECT_TRUE(honest.holds());
  EXPECT_TRUE(honest.is_settled);
  EXPECT_NEAR(honest.d_high, std::abs(1.959964 * 0.35 - 0.69), 1e-6);

  EXPECT_FALSE(ValidationOf(seen, 0.5, 1).holds());
  // Two digits need 4 (2.671 0.35 / 0.001)^2 = 3.5 million.
  EXPECT_FALSE(ValidationOf(seen, 0.35, 2).is_settled);
}

class StudyBudgetTest : public ::testing::Test {
 protected:
  StudyBudgetTest() {
    std::ofstream(folder_ / "gap.yaml")
        << "machine: gantry_router\nfidelity: fast\ncalibrate: [next_all]\n";
    std::ofstream(folder_ / "study.yaml")
        << "study:\n  scenarios: [gap.yaml]\n  trials: 400\n";
  }
  TempFolder folder_{};
};

// error = 2 (x - mean) + noise: with u(x) = 0.3 and noise of 0.8 the shares are 36 and
// 64 %; y has no part in it, and x_far, a fixed length from x, is x.
TEST_F(StudyBudgetTest, SharesAreThoseOfTheMadeUpErrors) {
  const Study study = ReadStudy(folder_ / "study.yaml");
  StudyStore store(folder_ / "out", study, /*may_resume=*/false);
  Rng rng(4, 0, "budget");
  for (std::int64_t trial = 0; trial < 400; ++trial) {
    const double x = 5 + 0.3 * rng.Normal(), y = rng.Normal();
    const double error = 2 * (x - 5) + 0.8 * rng.Normal();
    store.Add(
        {.trial = trial,
         .status = "recovers",
         .parameters = {
             {.name = "x", .unit = "mm", .injected = x},
             {.name = "x_far", .unit = "mm", .injected = 9 - x},
             {.name = "y", .unit = "mm", .injected = y},
             {.name = "z", .unit = "um", .injected = 7, .recovered = 7 + error}}});
  }
  const auto budgets = BudgetsOf(study, store);

  ASSERT_EQ(budgets.at(0).size(), 1U);
  const Budget& z = budgets[0][0];
  EXPECT_EQ(z.name, "z");
  EXPECT_NEAR(z.u, 1, 5 / std::sqrt(800));
  ASSERT_EQ(z.lines.size(), 2U);
  EXPECT_EQ(z.lines[0].input, "");
  EXPECT_EQ(z.lines[1].input, "x");
  const double chance = 5 * 0.8 / 0.3 / std::sqrt(400);
  EXPECT_NEAR(z.lines[1].c, 2, chance);
  EXPECT_NEAR(z.lines[1].share, 0.36, 0.36 * chance);
  EXPECT_NEAR(z.lines[0].share + z.lines[1].share, 1, 1e-12);
  EXPECT_THAT(BudgetText("first", budgets[0]), HasSubstr("readings and all else 0."));
}

TEST_F(StudyBudgetTest, AdaptiveIsReadAndRefusedWhereItCannotBe) {
  const auto fault_of = [&](const std::string& keys) -> std::string {
    std::ofstream(folder_ / "study.yaml") << "study:\n  scenarios: [gap.yaml]\n"
                                          << keys;
    try {
      const Study study = ReadStudy(folder_ / "study.yaml");
      return "digits " + std::to_string(study.adaptive_digits);
    } catch (const InputError& error) {
      return error.what();
    }
  };
  EXPECT_EQ(fault_of("  adaptive: {digits: 2}\n"), "digits 2");
  EXPECT_THAT(fault_of("  adaptive: {digits: 2}\n  trials: 5\n"),
              HasSubstr("stands beside `trials`"));
  EXPECT_THAT(fault_of("  adaptive: {digits: 9}\n"), HasSubstr("study.yaml:3:22"));
  EXPECT_THAT(fault_of("  adaptive: {digits: 2}\n  keep: none\n"),
              HasSubstr("keep: all"));
}

}  // namespace
}  // namespace caltwin
