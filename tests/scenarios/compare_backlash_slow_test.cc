#include <algorithm>

#include <gtest/gtest.h>

#include "scenarios/compare_backlash.h"

namespace caltwin {
namespace {

// A compensation in force is rounded to steps in every repeat alike: no number of
// repeats averages that away, and the interval has to say so.
TEST(CompareBacklash, TheDialIsAsSureAsItSays) {
  const BacklashComparison comparison = CompareBacklash(500, 11, [](int) {});
  const auto dial =
      std::ranges::find(comparison.engines, "dial", &BacklashStanding::name);
  ASSERT_EQ(dial->intervals, 500);
  // 95 % of 500, once in 100 000 further off.
  EXPECT_GT(dial->covered, 450);
  EXPECT_LT(dial->covered, 496);
}

}  // namespace
}  // namespace caltwin
