#include "tools/commands/starter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/machine/kinds/triple_z/drawing.h"

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

TEST(Starter, OtherKindsKeepTheirKeys) {
  Faults faults;
  const std::string text =
      "# Of the machine that it is like.\nname: triple\nkinematics: triple_z\n"
      "model: model.xml\nscrews: {z1: {at_mm: [30, 30]}}  # front left\n"
      "axes: {x: {max_mm: 235}, y: {max_mm: 235}, z: {max_mm: 250, lead_mm: 4}}\n";
  YamlMap map = ReadYamlText(StarterLike(text, "mine"), "mine.yaml", &faults);

  const Machine mine = ReadMachine(&map);

  faults.ThrowIfAny();
  EXPECT_THAT(mine.name, StrEq("mine"));
  EXPECT_TRUE(mine.model.empty());
  ASSERT_NE(mine.Own<TripleZDrawing>(), nullptr);
  EXPECT_THAT(TripleZOf(mine).screws[0].at_mm[0], DoubleEq(30));
}

}  // namespace
}  // namespace caltwin
