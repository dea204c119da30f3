#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenarios/museum.h"

namespace caltwin {
namespace {

// Every fault is worse than its cure, and both runs end as their scenarios say. Those
// that need a program of somebody else's run with it (Klipper.InLockStep,
// LinuxCNC.InLockStep).
TEST(Museum, EachCureIsBetterThanItsFault) {
  std::vector<Exhibit> exhibits = ReadExhibits("scenarios/museum/exhibits.yaml");
  EXPECT_GE(exhibits.size(), 20U);
  std::erase_if(exhibits, [](const Exhibit& one) { return !one.needs.empty(); });
  const auto shown = RunMuseum(exhibits, [](const std::string&) {});
  ASSERT_EQ(shown.size(), exhibits.size());
  for (const ExhibitShown& one : shown) {
    EXPECT_TRUE(one.fault.passed && one.cure.passed) << one.exhibit.fault;
    ASSERT_TRUE(one.fault.after && one.cure.after) << one.exhibit.fault;
    EXPECT_LT(*one.cure.after, *one.fault.after) << one.exhibit.fault;
  }
}

}  // namespace
}  // namespace caltwin
