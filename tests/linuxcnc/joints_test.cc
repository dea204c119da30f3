#include "sim/controllers/linuxcnc/joints.h"

#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/linuxcnc/fake_board.h"

namespace caltwin {
namespace linuxcnc {
namespace {

TEST(LinuxCncJoints, MoveByWholeStepsOnly) {
  FakeBoard board;
  Joints joints(&board);
  joints.Cycle(Both(0.4, -0.4));
  EXPECT_TRUE(board.followed.empty());
  joints.Cycle(Both(1.6, -0.6));
  ASSERT_EQ(board.followed.size(), 1U);
  EXPECT_EQ(board.followed[0], Both(2, -1));
  EXPECT_EQ(joints.steps(), Both(2, -1));
}

TEST(LinuxCncJoints, ASwitchIsTheBitOfItsJoint) {
  FakeBoard board;
  Joints joints(&board);
  EXPECT_EQ(joints.Cycle(Both(-99, 0)).switches, 0U);
  EXPECT_EQ(joints.Cycle(Both(-100, 0)).switches, 1U);
  EXPECT_EQ(joints.Cycle(Both(-100, -500)).switches, 1U);
}

TEST(LinuxCncJoints, TheProbeIsSeenInTheCycleThatReachesIt) {
  FakeBoard board;
  Joints joints(&board);
  EXPECT_FALSE(joints.Cycle(Both(49.4, 0)).probe);
  EXPECT_TRUE(joints.Cycle(Both(49.5, 0)).probe);
  EXPECT_TRUE(joints.Cycle(Both(49.5, 0)).probe);
  EXPECT_FALSE(joints.Cycle(Both(20, 0)).probe);
}

// The probe acts from 50 steps on: on the way from 40.2 to 60.2 from half a step
// before.
TEST(LinuxCncJoints, ALatchReportsWhereTheProbeClosed) {
  FakeBoard board;
  Joints joints(&board, {.is_latched = true});
  joints.Cycle(Both(40.2, 5));
  const Joints::Inputs seen = joints.Cycle(Both(60.2, 7));
  EXPECT_TRUE(seen.probe);
  EXPECT_NEAR(seen.reported_steps[0], 49.5, 0.03);
  EXPECT_NEAR(seen.reported_steps[1], 5 + 2 * (49.5 - 40.2) / 20, 0.003);
  EXPECT_EQ(joints.steps(), Both(60, 7));
  EXPECT_EQ(joints.Cycle(Both(62.2, 7)).reported_steps, Both(62.2, 7));
}

TEST(LinuxCncJoints, WithoutALatchTheyReportWhereTheyWereSent) {
  FakeBoard board;
  Joints joints(&board);
  joints.Cycle(Both(40.2, 0));
  EXPECT_EQ(joints.Cycle(Both(60.2, 0)).reported_steps, Both(60.2, 0));
}

TEST(LinuxCncJoints, AContactThatBouncesOpensAndClosesInTurns) {
  FakeBoard board;
  Joints joints(&board, {.bounce_s = 0.004});
  std::vector<bool> shown;
  for (int cycle = 0; cycle < 8; ++cycle) {
    shown.push_back(joints.Cycle(Both(60 + cycle, 0), 0.001 * cycle).probe);
  }
  EXPECT_THAT(shown,
              testing::ElementsAre(true, false, true, false, true, true, true, true));
  EXPECT_FALSE(joints.Cycle(Both(20, 0), 0.009).probe);
}

// While it still leaves the surface a new chance could close it again, and LinuxCNC
// stops at a probe that closes in a move that is no probing.
TEST(LinuxCncJoints, ChanceIsDrawnAnewOnceTheProbeHasBeenOpenForTwentyCycles) {
  FakeBoard board;
  Joints joints(&board);
  EXPECT_EQ(board.num_armed, 1);
  joints.Cycle(Both(60, 0));
  for (int i = 0; i < 19; ++i) joints.Cycle(Both(40, 0));
  EXPECT_EQ(board.num_armed, 1);
  for (int i = 0; i < 100; ++i) joints.Cycle(Both(40, 0));
  EXPECT_EQ(board.num_armed, 2);
}

}  // namespace
}  // namespace linuxcnc
}  // namespace caltwin
