#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/machine/kinds/kinds.h"
#include "sim/machine/kinds/triple_z/drawing.h"
#include "sim/machine/machine.h"
#include "sim/machine/screw_levelling.h"

namespace caltwin {
namespace {

using ::testing::HasSubstr;

const Pivots<double> kDrawn_mm = TripleZDrawing{}.pivots_mm();

Machine ReadText(const std::string& keys) {
  Faults faults;
  YamlMap map =
      ReadYamlText("kinematics: triple_z\n" + keys, "in_a_test.yaml", &faults);
  Machine machine = ReadMachine(&map);
  faults.ThrowIfAny();
  return machine;
}

TEST(ScrewWeights, AreOneAtTheirOwnScrewAndNoughtAtTheOthers) {
  for (int i = 0; i < kNumScrews; ++i) {
    const Eigen::Vector2d& at_mm = kDrawn_mm[static_cast<std::size_t>(i)];
    const Vec3<double> weights = ScrewWeights<double>(kDrawn_mm, at_mm[0], at_mm[1]);
    EXPECT_LT((weights - Vec3<double>::Unit(i)).norm(), 1e-14);
  }
}

// A plane is its own interpolation, outside the triangle too.
TEST(ScrewWeights, CarryAPlane) {
  const auto plane_mm = [](double x, double y) {
    return 3 + 0.01 * x - 0.02 * y;
  };
  const Vec3<double> heights_mm(plane_mm(20, 20), plane_mm(215, 20), plane_mm(20, 215));
  for (const Eigen::Vector2d& at_mm :
       {Eigen::Vector2d(0, 0), {230, 230}, {117, 40}, {-50, 300}}) {
    const Vec3<double> weights = ScrewWeights<double>(kDrawn_mm, at_mm[0], at_mm[1]);
    EXPECT_NEAR(weights.dot(heights_mm), plane_mm(at_mm[0], at_mm[1]), 1e-12);
    EXPECT_NEAR(weights.sum(), 1, 1e-14);
  }
}

TEST(LevelScrews, BringsATiltedBedToNought) {
  std::vector<BedTouch> touches;
  const auto height_mm = [](const Eigen::Vector2d& at) {
    return 0.3 + 0.004 * at[0] - 0.002 * at[1];
  };
  for (const Eigen::Vector2d& at : {Eigen::Vector2d(30, 30), {200, 40}, {60, 210}}) {
    touches.push_back({at, height_mm(at)});
  }

  const auto corrections = LevelScrews(kDrawn_mm, touches);

  ASSERT_TRUE(corrections);
  for (int i = 0; i < kNumScrews; ++i) {
    EXPECT_NEAR(corrections->raise_mm[i],
                -height_mm(kDrawn_mm[static_cast<std::size_t>(i)]),
                1e-12);
  }
  EXPECT_GT(corrections->deviation_before_mm, 0.1);
  EXPECT_LT(corrections->deviation_after_mm, 1e-12);
}

TEST(LevelScrews, WantsThreePlacesThatAreNotOnALine) {
  const std::vector<BedTouch> line = {
      {{20, 20}, 0}, {{80, 80}, 0.1}, {{200, 200}, 0.3}};

  EXPECT_FALSE(LevelScrews(kDrawn_mm, line));
  EXPECT_FALSE(LevelScrews(kDrawn_mm, std::span(line).first(2)));
}

TEST(TripleZMachineFile, NeedsNothingButItsKinematics) {
  const Machine machine = ReadText("");

  ASSERT_NE(machine.Own<TripleZDrawing>(), nullptr);
  EXPECT_EQ(machine.kind, TripleZKind());
  EXPECT_EQ(TripleZOf(machine).screws[1].at_mm, Eigen::Vector2d(215, 20));
  EXPECT_DOUBLE_EQ(machine.settings.steps_per_mm[2], 800);
  EXPECT_DOUBLE_EQ(machine.axis(Axis::kZ).home_mm(), 250);
}

TEST(TripleZMachineFile, TakesScrewsAndTravel) {
  const Machine machine = ReadText(
      "screws: {z3: {at_mm: [10, 300], lead_mm: 2}}\naxes: {z: {max_mm: 180}}\n");

  EXPECT_EQ(TripleZOf(machine).screws[2].at_mm, Eigen::Vector2d(10, 300));
  EXPECT_DOUBLE_EQ(TripleZOf(machine).screws[2].steps_per_mm(), 1600);
  EXPECT_DOUBLE_EQ(TripleZOf(machine).top_mm, 180);
}

TEST(TripleZMachineFile, RefusesScrewsInOneLine) {
  try {
    ReadText("screws: {z3: {at_mm: [120, 21]}}\n");
    FAIL() << "read";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("nearly in one line"));
  }
}

}  // namespace
}  // namespace caltwin
