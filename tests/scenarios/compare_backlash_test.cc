#include "scenarios/compare_backlash.h"

#include <algorithm>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace caltwin {
namespace {

const BacklashStanding& Of(const BacklashComparison& comparison,
                           std::string_view name) {
  return *std::ranges::find(comparison.engines, name, &BacklashStanding::name);
}

// What physics says of each: the published cluster crashes, two reversals read nothing,
// the published release counts M425 twice, and what is corrected recovers the gap.
TEST(CompareBacklash, EachAsItsGeometryMustHaveIt) {
  const BacklashComparison comparison = CompareBacklash(8, 3, [](int) {});

  ASSERT_EQ(comparison.engines.size(), BacklashRivals().size());
  const BacklashStanding& crash = Of(comparison, "cluster_as_published");
  EXPECT_EQ(crash.outcomes.at("collision"), 8);
  EXPECT_EQ(crash.failures, 8);
  for (const char* nothing : {"same_side", "away_return"}) {
    EXPECT_EQ(Of(comparison, nothing).outcomes.count("reads_zero"), 1U) << nothing;
  }
  for (const char* good : {"cluster_corrected", "release_corrected", "dial"}) {
    EXPECT_EQ(Of(comparison, good).failures, 0) << good;
    EXPECT_LT(Of(comparison, good).error_um.median, 2) << good;
  }
  EXPECT_GT(Of(comparison, "release_as_published").error_um.median, 5);
}

TEST(CompareBacklash, TheSameSeedGivesTheSameFigures) {
  const auto json = [] {
    return BacklashComparisonJson(CompareBacklash(3, 7, [](int) {})).dump();
  };
  EXPECT_EQ(json(), json());
}

}  // namespace
}  // namespace caltwin
