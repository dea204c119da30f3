#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/firmware/bench.h"

namespace caltwin {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr const char* kEmergency = "Emergency Stop! Reset the controller to continue.";

TEST(Firmware, HomesToTheEndsOfTheDrawing) {
  FirmwareBench bench;

  EXPECT_THAT(bench.Say({"G28"}), IsEmpty());

  EXPECT_THAT(bench.Say({"M114"}),
              ElementsAre("X:0.000 Y:0.000 Z:300.000 E:0.000 Count 0 0 240000 "
                          "Machine 0.000 0.000 300.000"));
  // The first axis to move was z: away from its switch, which was closed at the start.
  ASSERT_FALSE(bench.plant.segments.empty());
  EXPECT_EQ(bench.plant.segments[0].to_steps, Vec3<double>(0, 0, -5 * 800));
}

TEST(Firmware, MoveBeforeHomingIsRefused) {
  FirmwareBench bench;

  EXPECT_THAT(bench.Say({"G1 X10 F600"}),
              ElementsAre("Error: G0/G1: insufficient axes homed"));
  EXPECT_THAT(bench.Say({"G28 X", "G1 X10 F600"}), IsEmpty());
  EXPECT_THAT(bench.Say({"G1 Y10"}),
              ElementsAre("Error: G0/G1: insufficient axes homed"));
}

TEST(Firmware, MoveBeyondTheLimitsIsRefused) {
  FirmwareBench bench;
  bench.HomeAndCentre();

  EXPECT_THAT(bench.Say({"G0 X300.1"}),
              ElementsAre("Error: G0/G1: target position outside machine limits"));
  EXPECT_THAT(bench.Say({"G91", "G0 X-100.1"}),
              ElementsAre("Error: G0/G1: target position outside machine limits"));
  EXPECT_THAT(bench.Say({"G90", "G0 X300", "G0 X0"}), IsEmpty());
}

TEST(Firmware, ProbeMoveStopsOnTheStepNearestToTheTrigger) {
  FirmwareBench bench;
  bench.HomeAndCentre();
  bench.plant.wall_mm = 123.45678;

  EXPECT_THAT(bench.Say({"G38.2 X140 F300"}), IsEmpty());

  // At 5 mm/s the trigger itself is found to a nanosecond: the nearest step is it.
  EXPECT_EQ(bench.firmware.motor_steps()[0], std::round(123.45678 * 800));
  EXPECT_LE(bench.plant.largest_settling_steps, 0.5);
  EXPECT_THAT(bench.Say({"M114"}),
              ElementsAre("X:123.456 Y:100.000 Z:100.000 E:0.000 Count 98765 80000 "
                          "80000 Machine 123.456 100.000 100.000"));
}

TEST(Firmware, ProbeMovesSayWhatWentWrong) {
  FirmwareBench bench;
  bench.HomeAndCentre();

  EXPECT_THAT(bench.Say({"G38.2 X110 F300"}),
              ElementsAre("Error: Probe was not triggered during probing move"));
  EXPECT_THAT(bench.Say({"G38.3 X100 F300"}), IsEmpty());
  EXPECT_THAT(bench.Say({"G38.4 X110 F300"}),
              ElementsAre("Error: Probe not triggered before probing move started"));
  bench.plant.wall_mm = 120;
  EXPECT_THAT(bench.Say({"G38.2 X130 F300"}), IsEmpty());
  EXPECT_THAT(
      bench.Say({"G38.2 X130 F300"}),
      ElementsAre("Error: Probe already triggered before probing move started"));
  bench.plant.wall_mm = 50;
  EXPECT_THAT(bench.Say({"G38.4 X110 F300"}),
              ElementsAre("Error: Probe did not lose contact during probing move"));
  EXPECT_THAT(bench.Say({"G38.5 X100 F300"}), IsEmpty());
}

TEST(Firmware, ProbeAwayStopsAtTheRelease) {
  FirmwareBench bench;
  bench.HomeAndCentre();
  bench.plant.wall_mm = 120;
  bench.Say({"G38.2 X130 F300"});

  EXPECT_THAT(bench.Say({"G38.4 X110 F300"}), IsEmpty());

  EXPECT_NEAR(bench.firmware.motor_steps()[0], 120 * 800, 1);
}

TEST(Firmware, CollisionHaltsUntilM999) {
  FirmwareBench bench;
  bench.HomeAndCentre();
  bench.plant.alarm_mm = 150;

  EXPECT_THAT(bench.Say({"G1 X200 F3000"}), IsEmpty());  // Only queued.
  EXPECT_THAT(
      bench.Say({"M400"}),
      ElementsAre("Error: the stylus was bent beyond its overtravel", kEmergency));
  EXPECT_TRUE(bench.firmware.halted());
  EXPECT_NEAR(bench.plant.steps[0], 150 * 800, 1);
  EXPECT_TRUE(bench.firmware.Execute("G28").error);
  EXPECT_THAT(bench.Say({"G1 X100", "G28"}), ElementsAre(kEmergency, kEmergency));
  bench.plant.alarm_mm = 1e9;
  EXPECT_THAT(bench.Say({"M999", "G28", "G0 X20"}), IsEmpty());
  EXPECT_FALSE(bench.firmware.halted());
}

TEST(Firmware, EmergencyStopDropsTheQueue) {
  FirmwareBench bench;
  bench.HomeAndCentre();

  EXPECT_THAT(bench.Say({"G1 X200 F3000", "M112"}), ElementsAre(kEmergency));

  EXPECT_EQ(bench.plant.steps[0], 100 * 800);
  EXPECT_THAT(bench.Say({"M999", "G0 X10"}),
              ElementsAre("Error: G0/G1: insufficient axes homed"));
}

TEST(Firmware, WorkOffsetsShiftWhatIsCommanded) {
  FirmwareBench bench;
  bench.HomeAndCentre();

  bench.Say({"G10 L20 P1 X0 Y10", "G0 X5 Y10"});
  EXPECT_THAT(bench.Say({"M114"}).front(), HasSubstr("X:5.000 Y:10.000 Z:100.000"));
  EXPECT_THAT(bench.Say({"M114"}).front(), HasSubstr("Machine 105.000 100.000"));
  bench.Say({"G53 G0 X120"});
  EXPECT_THAT(bench.Say({"M114"}).front(), HasSubstr("X:20.000"));
  bench.Say({"G10 L2 P2 X50", "G55", "G0 X1"});
  EXPECT_THAT(bench.Say({"M114"}).front(), HasSubstr("Machine 51.000"));
}

TEST(Firmware, G92RedefinesTheMachinePosition) {
  FirmwareBench bench;
  bench.HomeAndCentre();

  bench.Say({"G92 X10"});

  EXPECT_THAT(bench.Say({"M114"}).front(), HasSubstr("Count 8000 80000 80000"));
  EXPECT_EQ(bench.firmware.motor_steps()[0], 80000);
  EXPECT_EQ(bench.plant.steps[0], 80000);
}

TEST(Firmware, NewStepsPerMmKeepThePositionAndRecountTheSteps) {
  FirmwareBench bench;
  bench.HomeAndCentre();

  EXPECT_THAT(bench.Say({"M92 X808", "M92"}),
              ElementsAre("Steps/mm: X: 808.000, Y: 800.000, Z: 800.000"));

  EXPECT_THAT(bench.Say({"M114"}).front(), HasSubstr("X:100.000"));
  EXPECT_THAT(bench.Say({"M114"}).front(), HasSubstr("Count 80800 "));
  EXPECT_EQ(bench.plant.steps[0], 80000);
  bench.Say({"G1 X110 F600", "M400"});
  EXPECT_EQ(bench.plant.steps[0], 80000 + 8080);
}

TEST(Firmware, RestartForgetsWhatWasNotWrittenDown) {
  FirmwareBench bench;
  bench.Say({"M92 X808", "M425 X0.05 S20", "global mine = 1", "M500", "M999"});

  EXPECT_EQ(bench.firmware.settings().steps_per_mm[0], 800);
  EXPECT_EQ(bench.firmware.settings().backlash_mm[0], 0);
  EXPECT_THAT(bench.Say({"echo exists(global.mine)"}), ElementsAre("false"));

  bench.Say({R"(echo >"sys/nxt-user-vars.g" "M92 X808")",
             R"(echo >>"sys/nxt-user-vars.g" "M425 X0.05")",
             "M999"});

  EXPECT_EQ(bench.firmware.settings().steps_per_mm[0], 808);
  EXPECT_EQ(bench.firmware.settings().backlash_mm[0], 0.05);
}

TEST(Firmware, M500SavesWorkOffsetsOnlyAndSaysThatNothingLoadsThem) {
  FirmwareBench bench;

  EXPECT_THAT(bench.Say({"M92 X808", "M425 X0.05", "G10 L2 P1 X12", "M500"}),
              ElementsAre("Warning: M500: No M501 command was executed in config.g"));

  const std::string& saved = bench.firmware.files().at("sys/config-override.g");
  EXPECT_THAT(saved, testing::Not(HasSubstr("M92")));
  EXPECT_THAT(saved, testing::Not(HasSubstr("M425")));
  EXPECT_THAT(saved, HasSubstr("G10 L2 P1 X12.000 Y0.000 Z0.000"));
}

TEST(Firmware, ConsecutiveMovesAreBlended) {
  FirmwareBench one;
  FirmwareBench many;
  one.HomeAndCentre();
  many.HomeAndCentre();
  const double before_s = one.firmware.machine_time_s();
  ASSERT_EQ(many.firmware.machine_time_s(), before_s);

  one.Say({"G1 X200 F3000", "M400"});
  for (int i = 1; i <= 100; ++i) {
    many.firmware.Execute("G1 X" + std::to_string(100 + i) + " F3000");
  }
  many.Say({"M400"});

  // 100 mm at 50 mm/s and 500 mm/s^2: L / v + v / a.
  EXPECT_NEAR(one.firmware.machine_time_s() - before_s, 2.1, 1e-9);
  EXPECT_NEAR(many.firmware.machine_time_s(), one.firmware.machine_time_s(), 1e-9);
}

TEST(Firmware, QueueIsPerformedLazilyAndBounded) {
  FirmwareBench bench;
  bench.HomeAndCentre();
  const std::size_t before = bench.plant.segments.size();

  for (int i = 1; i <= 100; ++i) {
    bench.firmware.Execute("G1 X" + std::to_string(100 + i) + " F3000");
  }

  EXPECT_GT(bench.plant.segments.size(), before);
  EXPECT_LT(bench.plant.segments.size(), before + 100);
  EXPECT_FALSE(bench.firmware.FinishMoves().error);
  EXPECT_EQ(bench.plant.segments.size(), before + 100);
}

TEST(Firmware, DwellsAreTimed) {
  FirmwareBench bench;
  bench.Say({"G4 S2", "G4 P500"});

  EXPECT_DOUBLE_EQ(bench.plant.dwelt_s, 2.5);
  EXPECT_DOUBLE_EQ(bench.firmware.machine_time_s(), 2.5);
}

TEST(Firmware, ObjectModelTellsWhatTheMacrosRead) {
  FirmwareBench bench;
  bench.HomeAndCentre();
  bench.Say({"M425 X0.05", "G10 L2 P2 X50", "G55"});

  EXPECT_THAT(
      bench.Say({R"(M409 K"move.axes[].letter" F"f")", R"(M409 K"move.axes[].homed")"}),
      ElementsAre(
          R"({"key":"move.axes[].letter","flags":"f","result":["X","Y","Z"]})",
          R"({"key":"move.axes[].homed","flags":"","result":[true,true,true]})"));
  EXPECT_THAT(bench.Say({"echo move.axes[0].userPosition, move.axes[0].machinePosition,"
                         " move.axes[0].backlash, move.axes[2].max"}),
              ElementsAre("50 100 0.05 300"));
  EXPECT_THAT(bench.Say({R"(M409 K"nothing.here")"}),
              ElementsAre(R"({"key":"nothing.here","flags":"","result":null})"));
  EXPECT_THAT(bench.Say({"echo sensors.probes[0].value[0], state.machineMode"}),
              ElementsAre("0 CNC"));
}

TEST(Firmware, NoiseIsAnsweredNotObeyed) {
  FirmwareBench bench;

  EXPECT_THAT(bench.Say({"G1 X{"}), ElementsAre(HasSubstr("Error: ")));
  EXPECT_THAT(bench.Say({"\x01\xff"}), ElementsAre(HasSubstr("Error: ")));
  EXPECT_THAT(bench.Say({"G1 X1e400"}), ElementsAre(HasSubstr("Error: ")));
  EXPECT_THAT(bench.Say({"M92 X-800"}), ElementsAre(HasSubstr("Error: ")));
  EXPECT_THAT(bench.Say({"M1234"}),
              ElementsAre("Warning: M1234: Command is not supported"));
  EXPECT_THAT(bench.Say({"", "; a remark", "(another)"}), IsEmpty());
  EXPECT_THAT(bench.Say({"echo " + std::string(500, '(')}),
              ElementsAre(HasSubstr("nested too deeply")));
}

// After a warning alone `G20`, `G0 X1` would go to 1 mm.
TEST(Firmware, RefusesWhatWouldSendLaterMovesElsewhere) {
  FirmwareBench bench;

  EXPECT_THAT(bench.Say({"G20"}), ElementsAre("Error: G20: not part of this machine"));
  EXPECT_THAT(bench.Say({"G2 X10 I5 J0"}),
              ElementsAre("Error: G2: not part of this machine"));
}

TEST(Firmware, SpeaksThroughM118) {
  FirmwareBench bench;

  EXPECT_THAT(bench.Say({R"(M118 P0 S"hello" L1)", "M118 GAUGE laser.x"}),
              ElementsAre("hello", "GAUGE laser.x"));
}

}  // namespace
}  // namespace caltwin
