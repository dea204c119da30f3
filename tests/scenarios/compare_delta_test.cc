#include "scenarios/kinds/compare_delta.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "sim/base/units.h"

namespace caltwin {
namespace {

std::vector<double> Counting(int last) {
  std::vector<double> values(static_cast<std::size_t>(last));
  std::iota(values.begin(), values.end(), 1);
  return values;
}

TEST(CompareDelta, TheMedianLiesBetweenItsOrderStatistics) {
  const Spread spread = SpreadOf(Counting(100));

  EXPECT_EQ(spread.median, 50.5);
  EXPECT_EQ(spread.p95, 95);
  // Ranks 40 and 61: the usual 95 % interval of the median of a hundred.
  EXPECT_EQ(spread.low, 40);
  EXPECT_EQ(spread.high, 61);
}

// The range of n values holds the median of what they come from but once in 2^(n - 1).
TEST(CompareDelta, FewerThanSixValuesHaveNoIntervalOf95Percent) {
  const Spread one = SpreadOf({3});
  EXPECT_EQ(one.median, 3);
  EXPECT_EQ(one.p95, 3);
  EXPECT_TRUE(std::isnan(one.low) && std::isnan(one.high));
  EXPECT_TRUE(std::isnan(SpreadOf({1, 2, 3, 4, 5}).low));
  EXPECT_EQ(SpreadOf({1, 2, 3, 4, 5, 6}).low, 1);
  EXPECT_EQ(SpreadOf({1, 2, 3, 4, 5, 6}).high, 6);
}

TEST(CompareDelta, AMachineIsTheSameWhoeverAsks) {
  const DeltaCase once = RandomDelta(1, 5), again = RandomDelta(1, 5);
  const DeltaCase other = RandomDelta(1, 6);

  EXPECT_EQ(once.build.rod_error_mm, again.build.rod_error_mm);
  EXPECT_NE(once.build.rod_error_mm, other.build.rod_error_mm);
}

TEST(CompareDelta, MachinesStayWithinWhatIsDocumented) {
  for (int i = 0; i < 200; ++i) {
    const DeltaCase one = RandomDelta(1, i);
    for (const double error_mm : one.build.rod_error_mm) {
      EXPECT_LE(std::abs(error_mm), 0.3);
    }
    EXPECT_NEAR(one.build.model.radius_mm[1], 130, 1);
    EXPECT_NEAR(DegFromRad(one.build.model.angle_rad[0]), 210, 0.5);
    EXPECT_LE(std::abs(one.bed.slope_x), 0.003);
  }
}

TEST(CompareDelta, EveryRivalMakesAMachineBetter) {
  std::vector<int> heard;
  const DeltaComparison comparison =
      CompareDelta(2, 1, [&](int done) { heard.push_back(done); });

  EXPECT_THAT(heard, testing::ElementsAre(0, 1));
  // A shipped program only where it is asked for.
  ASSERT_EQ(comparison.engines.size(),
            std::ranges::count_if(DeltaRivals(), [](const DeltaRival& rival) {
              return rival.calibrate != nullptr;
            }));
  for (const DeltaStanding& engine : comparison.engines) {
    EXPECT_EQ(engine.failures, 0) << engine.name;
    EXPECT_GE(engine.touches, 7) << engine.name;
    EXPECT_LT(engine.z_rms_um.p95, 60) << engine.name;
  }
}

TEST(CompareDelta, ItsJsonHoldsWhatTheContractNames) {
  const nlohmann::json json = DeltaComparisonJson(CompareDelta(1, 3, [](int) {}));

  EXPECT_EQ(json["format"], 1);
  EXPECT_EQ(json["kind"], "delta");
  EXPECT_EQ(json["machines"], 1);
  EXPECT_EQ(json["seed"], 3);
  for (const nlohmann::json& engine : json["engines"]) {
    EXPECT_TRUE(engine["name"].is_string());
    EXPECT_EQ(engine["z_rms_um"]["ci95"].size(), 2U);
    EXPECT_TRUE(engine["xy_scale_um_per_mm"]["p95"].is_number());
    EXPECT_TRUE(engine["touches"].is_number() && engine["time_s"].is_number());
  }
}

}  // namespace
}  // namespace caltwin
