#include "tools/commands/starter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace caltwin {
namespace {

using ::testing::DoubleEq;
using ::testing::Eq;
using ::testing::IsEmpty;
using ::testing::StrEq;

TEST(Starter, ReadsBackAsTheMachineItIsLike) {
  const Machine like = ReadMachine("models/gantry_router/machine.yaml");
  Faults faults;
  YamlMap map = ReadYamlText(StarterText(like, "mine"), "mine.yaml", &faults);

  const Machine mine = ReadMachine(&map);

  faults.ThrowIfAny();
  EXPECT_THAT(mine.name, StrEq("mine"));
  EXPECT_TRUE(mine.model.empty());
  for (const Axis axis : kAxes) {
    EXPECT_THAT(mine.axis(axis).max_mm, DoubleEq(like.axis(axis).max_mm));
    EXPECT_THAT(mine.axis(axis).home, Eq(like.axis(axis).home));
    EXPECT_THAT(mine.axis(axis).moving_mass_kg,
                DoubleEq(like.axis(axis).moving_mass_kg));
    EXPECT_THAT(mine.axis(axis).counterbalance_n,
                DoubleEq(like.axis(axis).counterbalance_n));
  }
  EXPECT_THAT(mine.probe.overtravel_mm, DoubleEq(like.probe.overtravel_mm));
  EXPECT_THAT(mine.settings.steps_per_mm, Eq(like.settings.steps_per_mm));
}

}  // namespace
}  // namespace caltwin
