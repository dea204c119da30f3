#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include "scenarios/museum.h"

namespace caltwin {
namespace {

// Machine, effects and what lies on it are alike for a fault and its cure.
TEST(Museum, ACureIsOnTheMachineOfItsFault) {
  for (const Exhibit& one : ReadExhibits("scenarios/museum/exhibits.yaml")) {
    const YAML::Node fault = YAML::LoadFile(one.as_published.string());
    const YAML::Node cured = YAML::LoadFile(one.cured.string());
    for (const std::string key : {"machine", "effects", "station", "artefacts"}) {
      if (key == one.cure_changes) continue;
      EXPECT_EQ(YAML::Dump(fault[key]), YAML::Dump(cured[key]))
          << one.fault << ": " << key;
    }
  }
}

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
    EXPECT_LT(*one.cure.after, 0.3 * *one.fault.after) << one.exhibit.fault;
  }
}

}  // namespace
}  // namespace caltwin
