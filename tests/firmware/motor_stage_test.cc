#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/firmware/kinds/motor_stage/controller.h"

namespace caltwin {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kTick_s = 0.00025;

/// Motors that are where they are told, a switch at -3000 pulses, an index a turn.
class IdealRig : public MotorRig {
 public:
  double tick_s() const override { return kTick_s; }
  void Tick(const RigDrives& drives) override {
    for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
      if (drives[i].mode != RigDrive::Mode::kFollow) continue;
      const auto to = static_cast<std::int64_t>(std::llround(drives[i].to_pulses));
      const std::int64_t turn = 10'000;
      const std::int64_t line = ((to + 100 * turn) / turn - 100) * turn;
      if (counts[i] < line && line <= to) edges[i].push_back(line);
      counts[i] = to;
    }
  }
  std::int64_t Count(std::size_t axis) const override { return counts[axis]; }
  double CurrentOf(std::size_t axis) const override {
    return axis == 1 ? current_y_a : 1;
  }
  bool IsPressed(std::size_t axis, SwitchEnd end) const override {
    return end == SwitchEnd::kMin && counts[axis] <= -3000;
  }
  std::vector<std::int64_t> TakeIndexEdges(std::size_t axis) override {
    return std::exchange(edges[axis], {});
  }

  std::array<std::int64_t, kNumMotorAxes> counts{};
  std::array<std::vector<std::int64_t>, kNumMotorAxes> edges{};
  double current_y_a = 1;
};

MotorStageOptions Options() {
  MotorStageOptions options;
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    options.motion.is_servo[i] = i < 4;
    options.motion.limit_a[i] = 10;
  }
  return options;
}

class MotorStageFirmwareTest : public ::testing::Test {
 protected:
  std::vector<std::string> Say(const std::string& line) {
    return firmware_.Execute(line).lines;
  }
  std::string LineOf(const std::string& command, char letter) {
    for (const std::string& line : Say(command)) {
      if (line.starts_with(letter)) return line;
    }
    return "";
  }

  IdealRig rig_;
  Flash flash_;
  MotorStageFirmware firmware_{Options(), &rig_, &flash_};
};

TEST(TrapezoidPath, GoesItsLengthAndNoFaster) {
  const TrapezoidPath path(100, 50, 200);

  EXPECT_DOUBLE_EQ(path.duration_s(), 100 / 50.0 + 50 / 200.0);
  EXPECT_DOUBLE_EQ(path.At(path.duration_s()), 100);
  EXPECT_DOUBLE_EQ(path.At(0.25), 200 * 0.25 * 0.25 / 2);
  EXPECT_NEAR((path.At(1.001) - path.At(1)) / 0.001, 50, 1e-9);
  // Too short to reach it: up to sqrt(length acceleration).
  EXPECT_DOUBLE_EQ(TrapezoidPath(2, 50, 200).duration_s(), 2 * std::sqrt(2 / 200.0));
}

TEST(TrapezoidPath, StopsFromItsSpeedOnTheWay) {
  TrapezoidPath path(100, 50, 200);
  const double before = path.At(1);
  path.StopFrom(1, 1000);

  EXPECT_DOUBLE_EQ(path.duration_s(), 1.05);
  EXPECT_DOUBLE_EQ(path.At(5), before + 50 * 50 / 2000.0);
}

TEST_F(MotorStageFirmwareTest, MovesByPulsesPerMm) {
  EXPECT_THAT(Say("M92 X400.123"), IsEmpty());
  EXPECT_THAT(Say("G90 G1 X10 F600"), IsEmpty());
  EXPECT_THAT(Say("M400"), IsEmpty());

  EXPECT_EQ(rig_.counts[0], 4001);
  EXPECT_EQ(LineOf("M114", 'X'), "X:10.00000 Count 4001");
}

TEST_F(MotorStageFirmwareTest, SeesASwitchLateOverTheExpander) {
  Say("G91");
  EXPECT_THAT(Say("G1 H4 X-20 F600"), IsEmpty());  // 10 mm/s, 1000 pulses/mm

  // At -3 mm; seen up to 5.4 ms and two ticks later; then v^2 / 2 a = 0.05 mm.
  EXPECT_LE(rig_.counts[0], -3000 - 50);
  EXPECT_GE(rig_.counts[0], -3000 - 50 - 10 * 6);
  EXPECT_THAT(LineOf("M119", 'x'), "x_min: TRIGGERED x_max: open");
  EXPECT_THAT(Say("G1 H4 X5 F600"),
              ElementsAre("Error: G1: X MAX switch not found within 5"));
}

TEST_F(MotorStageFirmwareTest, LatchesTheCounterAtTheIndex) {
  Say("G91");
  EXPECT_THAT(Say("G1 H5 X12 F6000"), IsEmpty());

  EXPECT_THAT(LineOf("M814 X", 'X'), HasSubstr("edges 1"));
  EXPECT_THAT(LineOf("M814 X", 'X'), HasSubstr(" index 10000"));
  Say("M811 X10000");
  EXPECT_THAT(LineOf("M814 X", 'X'), HasSubstr("homed 1"));
  EXPECT_THAT(LineOf("M814 X", 'X'), HasSubstr(" index 0"));
  EXPECT_THAT(Say("G1 H5 X2 F6000"),
              ElementsAre("Error: G1: X index not found within 2"));
}

TEST_F(MotorStageFirmwareTest, GoesFartherByTheBacklashMovingBack) {
  Say("M425 X0.02");
  Say("G90 G1 X10 F600");
  EXPECT_EQ(rig_.counts[0], 10'000);
  Say("G1 X5");
  EXPECT_EQ(rig_.counts[0], 5000 - 20);
  EXPECT_THAT(LineOf("M114", 'X'), HasSubstr("X:5.00000"));
  Say("G1 X10");
  EXPECT_EQ(rig_.counts[0], 10'000);
}

TEST_F(MotorStageFirmwareTest, StopsWhereTheCurrentStaysAtItsLimit) {
  rig_.current_y_a = 10;

  // 30 ms at up to 10 mm/s, reached by 1000 mm/s2: v t - v^2 / 2 a = 0.25 mm.
  EXPECT_THAT(Say("G91 G1 Y20 F600"),
              ElementsAre("Error: Y is blocked at 0.250: at its current limit for 30 "
                          "ms, stopped there"));
}

// Cut off or rounded, the record would hold what nobody sent.
TEST_F(MotorStageFirmwareTest, RefusesWhatAFieldCannotHold) {
  EXPECT_THAT(Say("M206 X9999999"), ElementsAre(HasSubstr("M206 X: up to 2147483647")));
  EXPECT_THAT(Say("M208 X9999999 S0"),
              ElementsAre(HasSubstr("M208 X: up to 2147483647")));
  EXPECT_THAT(Say("M812 X1.5"), ElementsAre(HasSubstr("M812 X: whole pulses")));
  EXPECT_THAT(Say("M813 X3"), ElementsAre(HasSubstr("M813 X: 0 or 1")));
  EXPECT_THAT(Say("M206"), Contains("X:0"));
}

// "Xnan" would pass for four words without numbers: a query.
TEST_F(MotorStageFirmwareTest, RefusesNumbersThatAreNone) {
  for (const char* code : {"M92",
                           "M201",
                           "M203",
                           "M206",
                           "M208",
                           "M425",
                           "M812",
                           "M813",
                           "M811",
                           "M816",
                           "G1",
                           "G0"}) {
    const std::string name = code;
    EXPECT_THAT(Say(name + " Xnan"), ElementsAre(HasSubstr("Error: " + name + ": ")))
        << name;
    EXPECT_THAT(Say(name + " Xinf"), ElementsAre(HasSubstr("Error: "))) << name;
    EXPECT_THAT(Say(name + " X1e3"), ElementsAre(HasSubstr(": E is no word of it")))
        << name;
    EXPECT_THAT(Say(name + " X\"5\""), ElementsAre(HasSubstr(": X wants a number")))
        << name;
    EXPECT_THAT(Say(name + " X1 X2"), ElementsAre(HasSubstr(": X stands 2 times")))
        << name;
  }
  EXPECT_THAT(Say("M425 Xnan"),
              ElementsAre("Error: M425: N is no word of it; a number is written like "
                          "12.5"));
  EXPECT_THAT(Say("G1 X5 F"), ElementsAre(HasSubstr("G1: F wants a number")));
  EXPECT_THAT(Say("M817 Snan"), ElementsAre(HasSubstr("M817: ")));
  EXPECT_THAT(Say("G4 Sinf"), ElementsAre(HasSubstr("G4: ")));
  EXPECT_THAT(Say("M17 X1"), ElementsAre(HasSubstr("M17: X wants nothing")));
  EXPECT_THAT(Say("M811 X"), ElementsAre(HasSubstr("M811: X wants a number")));
  EXPECT_THAT(Say("M114 X"), ElementsAre(HasSubstr("M114: X is no word of it")));
  EXPECT_EQ(LineOf("M425", 'X'), "X:0");
  EXPECT_EQ(rig_.counts[0], 0);
}

TEST_F(MotorStageFirmwareTest, KeepsARecordOverAPowerCycle) {
  Say("M92 X409.6");
  Say("M425 X0.05");
  EXPECT_THAT(Say("M500 X"), IsEmpty());

  MotorStageFirmware later(Options(), &rig_, &flash_);
  EXPECT_EQ(later.record(0).pulses_per_unit, 409.6);
  EXPECT_EQ(later.record(0).backlash_pulses, 0.05 * 409.6);
  EXPECT_EQ(later.record(1).pulses_per_unit, 1000);
  EXPECT_THAT(later.Execute("M505 X P\"index missing\"").lines, IsEmpty());
  EXPECT_THAT(later.Execute("M504").lines,
              ElementsAre("1 2026-01-01T00:00:00Z x: calibrated",
                          "2 2026-01-01T00:00:00Z x: index missing"));
  EXPECT_THAT(later.Execute("M502").lines, IsEmpty());
  EXPECT_EQ(later.record(0).pulses_per_unit, 1000);
}

TEST_F(MotorStageFirmwareTest, RefusesWhatNoRecordMayHold) {
  EXPECT_THAT(Say("M92 X0"),
              ElementsAre("Error: M92 X: pulses_per_unit = 0, allowed 0.001 to 1e+07"));
  EXPECT_THAT(Say("M208 X2000 S1"),
              ElementsAre(HasSubstr("allowed below max_position_pulses")));
  EXPECT_THAT(Say("M208 X0:5"), ElementsAre(HasSubstr("Error: ")));
  EXPECT_THAT(Say("M999999"), ElementsAre(HasSubstr("is not known to this machine")));
  EXPECT_THAT(Say("G1 X1 Y1 H4"), ElementsAre("Error: H4 and H5 move one axis"));
}

TEST_F(MotorStageFirmwareTest, AnEmergencyStopHoldsUntilItIsCleared) {
  Say("M817 S0.2");
  EXPECT_THAT(Say("G91 G1 X20 F600"),
              ElementsAre("Error: emergency stop during the move"));
  EXPECT_THAT(Say("G1 X1"), ElementsAre("Error: emergency stop: M999 clears it"));
  EXPECT_THAT(LineOf("M818", 'X'), HasSubstr("stood 1 enabled 0"));
  Say("M999");
  EXPECT_THAT(Say("G1 X1"), ElementsAre("Error: X is disabled: M17 enables it"));
  Say("M17");
  EXPECT_THAT(Say("G1 X1"), IsEmpty());
}

// While an axis is homed nobody knows where its zero is: no limit holds. With the next
// zero they do again.
TEST_F(MotorStageFirmwareTest, LimitsHoldFromOneHomingToTheNext) {
  Say("M811 X0");
  Say("M208 X0 S1");
  Say("M208 X2 S0");
  EXPECT_THAT(Say("G90 G1 X3 F600"), ElementsAre(HasSubstr("outside its limits")));

  EXPECT_THAT(Say("M810 X"), IsEmpty());
  EXPECT_THAT(LineOf("M814 X", 'X'), HasSubstr("homed 0 was_homed 1"));
  EXPECT_THAT(Say("G90 G1 X3 F600"), IsEmpty());
  Say("M400");
  Say("M811 X3000");

  EXPECT_THAT(LineOf("M814 X", 'X'), HasSubstr("homed 1 was_homed 1"));
  EXPECT_THAT(Say("G90 G1 X3 F600"), ElementsAre(HasSubstr("outside its limits")));
}

// An encoder counts on without power; a stepper's rotor is anywhere.
// At a switch it stands outside: nearer it may come, farther it may not.
TEST_F(MotorStageFirmwareTest, WhatStandsOutsideItsLimitsMayComeBack) {
  Say("M811 X0");
  Say("G90 G1 X50 F6000");
  Say("M208 X40 S0");
  Say("M208 X0 S1");

  EXPECT_THAT(Say("G1 X51"), Contains(HasSubstr("is outside its limits")));
  EXPECT_THAT(Say("G1 X45"), IsEmpty());
  EXPECT_THAT(Say("G1 X46"), Contains(HasSubstr("is outside its limits")));
  EXPECT_THAT(Say("G1 X20"), IsEmpty());
}

// Stored with a record whose limits nobody measured, the factory's hold no more than
// before.
TEST_F(MotorStageFirmwareTest, LimitsOfTheFactoryDoNotHold) {
  Say("M500 X");
  Say("M501");
  Say("M811 X0");

  EXPECT_THAT(Say("G90 G1 X1500 F600000"), IsEmpty());  // The factory has 1000.
}

// Armed for the next move, it does not wait for a later one.
TEST_F(MotorStageFirmwareTest, TheRelayIsOfTheNextMoveAlone) {
  Say("M817 S9");
  Say("G91 G1 X1 F600");

  EXPECT_THAT(Say("G1 X200 F600"), IsEmpty());
}

// 20 mm of gap on 10 mm of way: the motor goes 30, no faster than it was told.
TEST_F(MotorStageFirmwareTest, TakesUpItsGapNoFasterThanItMoves) {
  Say("M425 X20");
  Say("G91");
  const double before_s = firmware_.machine_time_s();
  Say("G1 X-10 F600");

  EXPECT_GT(firmware_.machine_time_s() - before_s, 3.0);
}

TEST_F(MotorStageFirmwareTest, RefusesTimesAndEndsThatAreNone) {
  for (const char* line : {"G4 S-1", "G4 S4000", "M817 S-1", "M208 X100 S2"}) {
    EXPECT_THAT(Say(line), ElementsAre(HasSubstr("Error: "))) << line;
  }
}

// Others have what they had, stored or not.
TEST_F(MotorStageFirmwareTest, AResetOfOneAxisLeavesTheOthers) {
  Say("M203 Y7");
  Say("M203 X7");
  Say("M502 X");

  EXPECT_EQ(LineOf("M203 Y", 'Y'), "Y:7");
  EXPECT_NE(LineOf("M203 X", 'X'), "X:7");
}

TEST_F(MotorStageFirmwareTest, AStepperWithoutPowerIsNotHomedAnyMore) {
  Say("M811 X0 U0");
  Say("M18 X U");
  Say("M17 X U");

  EXPECT_THAT(LineOf("M814 X", 'X'), HasSubstr("homed 1 was_homed 1"));
  EXPECT_THAT(LineOf("M814 U", 'U'), HasSubstr("homed 0 was_homed 1"));
  Say("M811 U0");
  Say("M112");
  EXPECT_THAT(LineOf("M814 U", 'U'), HasSubstr("homed 0 was_homed 1"));
}

TEST_F(MotorStageFirmwareTest, TellsTheDelaysInForceAndRefusesOthers) {
  EXPECT_THAT(Say("M816 X0.0005"), IsEmpty());

  EXPECT_EQ(LineOf("M816 X", 'X'), "X:0.0005");
  EXPECT_THAT(Say("M816 X-0.001"),
              ElementsAre("Error: M816 X: 0 to 0.1 s are allowed"));
  EXPECT_EQ(LineOf("M816 X", 'X'), "X:0.0005");
}

}  // namespace
}  // namespace caltwin
