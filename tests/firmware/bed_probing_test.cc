#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/firmware/firmware.h"
#include "tests/firmware/screw_bed.h"

namespace caltwin {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

const Pivots<double> kPivots_mm = TripleZDrawing{}.pivots_mm();

// A flat bed that rises by 2 mrad along x, its screws where they are drawn; over its
// edge there is nothing.
double TiltedBed_mm(const Vec3<double>& raised_mm, double x_mm, double y_mm) {
  if (x_mm > 230) return -100;
  return 0.002 * x_mm + ScrewWeights<double>(kPivots_mm, x_mm, y_mm).dot(raised_mm);
}

class BedProbingTest : public ::testing::Test {
 protected:
  Reply Say(const std::string& line) { return firmware_.Execute(line); }
  // Whatever was asked for is done without complaint.
  void SayAll(const std::vector<std::string>& lines) {
    for (const std::string& line : lines) {
      const Reply reply = Say(line);
      EXPECT_FALSE(reply.error) << line << ": " << reply.lines.back();
    }
  }
  Machine machine_ = ScrewBedMachine();
  ScrewBed bed_{TiltedBed_mm};
  Firmware firmware_{
      machine_,
      machine_.settings,
      {.leadscrews = Leadscrews{.at_mm = kPivots_mm}, .probe_recovery_s = 0.2},
      &bed_};
};

TEST_F(BedProbingTest, SaysAtWhichHeightTheProbeStopped) {
  SayAll({"G28"});

  EXPECT_THAT(Say("G30 X125 Y50 S-1").lines, ElementsAre("Stopped at height 0.250 mm"));
}

TEST_F(BedProbingTest, MovesADriverAloneThroughItsOwnAxis) {
  SayAll({"G28",
          "G1 Z10",
          "M584 Z0 U1 V2 P5",
          "G92 U10",
          "G1 U9",
          "M584 Z0:1:2 P3 ; no U, V",
          "G92 Z10"});

  EXPECT_LT((firmware_.raised_mm() - Vec3<double>(0, 1, 0)).norm(), 1e-9);
  EXPECT_THAT(Say("G30 X215 Y20 S-1").lines,
              ElementsAre("Stopped at height 1.430 mm"));  // 0.002 215 + 1
}

// RepRapFirmware gives a new axis no position of Z's.
TEST_F(BedProbingTest, NewAxesAreNotHomedBeforeG92) {
  SayAll({"G28", "G1 Z10", "M584 Z0 U1 V2 P5"});

  EXPECT_TRUE(Say("G1 U9").error);
  EXPECT_THAT(Say("M114").lines[0], HasSubstr("Z:10.000 U:0.000 V:0.000"));
  EXPECT_FALSE(Say("G92 U10").error);
  EXPECT_FALSE(Say("G1 U9").error);
  EXPECT_TRUE(Say("G1 V9").error);
}

TEST_F(BedProbingTest, RefusesNumbersThatAreNone) {
  SayAll({"G28"});

  EXPECT_TRUE(Say("M92 Z0").error);
  EXPECT_TRUE(Say("M671 Xnan:1:2 Y1:2:3").error);
  EXPECT_THAT(Say("G30 X125 Y50 S-1").lines, ElementsAre("Stopped at height 0.250 mm"));
}

TEST_F(BedProbingTest, LevelsByItsDriversAsRepRapFirmwareSaysIt) {
  SayAll({"G28",
          "G30 P0 X20 Y20 Z-99999",
          "G30 P1 X215 Y20 Z-99999",
          "G30 P2 X20 Y215 Z-99999"});

  const Reply reply = Say("G30 P3 X205 Y205 Z-99999 S3");

  ASSERT_EQ(reply.lines.size(), 1U);
  EXPECT_THAT(reply.lines[0],
              HasSubstr("Leadscrew adjustments made: -0.040 -0.430 -0.040, points used "
                        "4, (mean, deviation) before (0.230, 0.190) after ("));
  EXPECT_THAT(Say("G30 X200 Y30 S-1").lines, ElementsAre("Stopped at height 0.000 mm"));
}

TEST_F(BedProbingTest, RefusesCorrectionsBeyondItsLimit) {
  SayAll({"M671 S0.1", "G28", "G30 P0 X20 Y20 Z-99999", "G30 P1 X215 Y20 Z-99999"});

  const Reply reply = Say("G30 P2 X20 Y215 Z-99999 S3");

  EXPECT_TRUE(reply.error);
  EXPECT_THAT(reply.lines[0], HasSubstr("exceed configured limit of 0.10mm"));
  EXPECT_LT(firmware_.raised_mm().norm(), 1e-9);
}

TEST_F(BedProbingTest, NamesWhatItDoesNotDo) {
  EXPECT_THAT(Say("G30 X20 Y20").lines[0], HasSubstr("insufficient axes homed"));
  SayAll({"G28"});
  EXPECT_THAT(Say("G30 X232 Y20 S-1").lines,
              ElementsAre("Error: Probe was not triggered during probing move"));
  EXPECT_THAT(Say("G1 X236").lines[0], HasSubstr("outside machine limits"));
  EXPECT_THAT(Say("G1 U5").lines[0], HasSubstr("no axes U and V"));
  EXPECT_THAT(Say("G31 X20").lines[0], HasSubstr("G31: Command is not supported"));
  EXPECT_THAT(Say("M584 Z0:2 U1").lines[0], HasSubstr("M584"));
}

TEST_F(BedProbingTest, KeepsScrewsAsTheyAreSet) {
  SayAll({"M671 X30:200:30 Y25:25:210 S5"});

  EXPECT_THAT(Say("M671").lines,
              ElementsAre("leadscrews at (30.0, 25.0), (200.0, 25.0), (30.0, 210.0), "
                          "maximum correction 5.00mm"));
}

TEST_F(BedProbingTest, ProbesWithinItsTravelAlone) {
  firmware_.Execute("G28");

  EXPECT_TRUE(firmware_.Execute("G30 X9999 Y20 S-1").error);
  EXPECT_TRUE(firmware_.Execute("G30 Xfoo S-1").error);
  EXPECT_TRUE(firmware_.Execute("M671 S-3").error);
  EXPECT_TRUE(firmware_.Execute("M671 X1:2:z").error);
  EXPECT_FALSE(firmware_.Execute("G30 X230 Y20 S-1").error);
}

// M584 names a driver for it that is not there: alone it stays, with the others it
// goes.
TEST(BedProbing, ADriverThatIsNotThereStaysAlone) {
  const Machine machine = ScrewBedMachine();
  ScrewBed bed{TiltedBed_mm};
  Firmware firmware(machine,
                    machine.settings,
                    {.leadscrews = Leadscrews{.at_mm = kPivots_mm}, .still_alone = 1},
                    &bed);
  for (const char* line :
       {"G28", "G1 Z10", "M584 Z0 U1 V2 P5", "G92 U10 V10", "G1 U9 V11.5"}) {
    EXPECT_FALSE(firmware.Execute(line).error) << line;
  }

  EXPECT_LT((firmware.raised_mm() - Vec3<double>(0, 0, -1.5)).norm(), 1e-9);
}

// Each screw has a switch of its own: homing takes back what they were raised.
TEST_F(BedProbingTest, HomingPutsEveryScrewAtItsSwitch) {
  SayAll({"G28", "G1 Z10", "M584 Z0 U1 V2 P5", "G92 U10 V10", "G1 U9 V11.5"});
  EXPECT_LT((firmware_.raised_mm() - Vec3<double>(0, 1, -1.5)).norm(), 1e-9);

  SayAll({"G28"});

  EXPECT_LT(firmware_.raised_mm().norm(), 1e-9);
  EXPECT_THAT(Say("M119").lines,
              ElementsAre("Endstops - X: at min stop, Y: at min stop, Z: at max stop, "
                          "Z probe: not stopped"));
  EXPECT_THAT(Say("G30 X125 Y50 S-1").lines, ElementsAre("Stopped at height 0.250 mm"));
}

// Motors do not move when M92 changes what a millimetre is.
TEST_F(BedProbingTest, ScrewsStayWhereTheyAreWhenTheirStepsChange) {
  SayAll({"G28", "G1 Z10", "M584 Z0 U1 V2 P5", "G92 U10", "G1 U9", "M584 Z0:1:2 P3"});
  const Motors before = firmware_.motor_steps();

  SayAll({"M92 Z400"});

  EXPECT_EQ(firmware_.motor_steps(), before);
  EXPECT_NEAR(firmware_.raised_mm()[1] - firmware_.raised_mm()[0], 1, 1e-9);
}

// A bed over the dive height bends what comes down on it.
TEST_F(BedProbingTest, RefusesABedThatStandsOverTheDiveHeight) {
  SayAll({"G28", "G1 Z10", "M584 Z0 U1 V2 P5", "G92 U10 V10", "G1 Z1 U1 V1"});
  SayAll({"M584 Z0:1:2 P3", "G92 Z10"});

  EXPECT_THAT(
      Say("G30 X20 Y20 S-1").lines,
      ElementsAre("Error: Probe already triggered before probing move started"));
  EXPECT_TRUE(firmware_.probed().empty());
}

TEST_F(BedProbingTest, SplittingHomesNothing) {
  SayAll({"M584 Z0 U1 V2 P5", "M584 Z0:1:2 P3"});
  EXPECT_TRUE(Say("G1 Z10").error);
  SayAll({"G28", "M18 Z", "M584 Z0 U1 V2 P5", "M584 Z0:1:2 P3"});
  EXPECT_TRUE(Say("G30 X20 Y20 S-1").error);
  SayAll(
      {"M584 Z0 U1 V2 P5", "G92 Z10 U10 V10", "G1 Z9.5", "M584 Z0:1:2 P3", "G1 Z10"});
}

TEST_F(BedProbingTest, ZKeepsItsWorkOffsetWhileSplit) {
  SayAll({"G28", "G1 Z10", "G10 L2 P1 Z1", "M584 Z0 U1 V2 P5"});
  EXPECT_THAT(Say("M114").lines[0], HasSubstr("Z:9.000 U:0.000"));
  SayAll({"G92 U9 V9", "G1 Z9", "M584 Z0:1:2 P3"});
  EXPECT_LT(firmware_.raised_mm().norm(), 1e-9);
}

TEST_F(BedProbingTest, NoScrewGoesBeyondItsTravelAndARefusedLineMovesNothing) {
  SayAll({"G28", "G1 X10 Z10", "M584 Z0 U1 V2 P5", "G92 U10"});
  EXPECT_TRUE(Say("G1 X50 V9").error);
  EXPECT_TRUE(Say("G1 X50 U9999").error);
  EXPECT_THAT(Say("M114").lines[0], HasSubstr("X:10.000"));
  SayAll({"G1 U240", "M584 Z0:1:2 P3"});
  EXPECT_THAT(Say("G1 Z250").lines[0], HasSubstr("outside machine limits"));
  SayAll({"G28", "G1 Z10"});
  EXPECT_TRUE(Say("G92 Z1" + std::string(200, '0')).error);
}

// What it was told does not depend on the sense in which the screws came.
TEST_F(BedProbingTest, BacklashStepsAreNoHeight) {
  SayAll({"M425 Z0.1 S1", "G28", "G30 X20 Y20 S-1", "G30 X20 Y20 S-1"});

  EXPECT_LT(firmware_.probed()[1].raised_mm.norm(), 1e-9);
  EXPECT_EQ(firmware_.probed()[1].backlash_mm, 0.1);
}

TEST_F(BedProbingTest, RestartsWithTheScrewsItBeganWith) {
  SayAll({"M671 X30:200:30 Y25:25:210 S5", "M999"});
  EXPECT_THAT(Say("M671").lines[0], HasSubstr("(20.0, 20.0)"));
}

// G30 with neither P nor S sets Z; with a Z it takes that height for granted.
TEST_F(BedProbingTest, AloneItSaysWhereZIs) {
  SayAll({"G28", "G30 X125 Y50"});
  EXPECT_THAT(Say("G30 X125 Y50 S-1").lines, ElementsAre("Stopped at height 0.000 mm"));
  SayAll({"G30 P0 X20 Y20 Z0.1", "G30 P1 X215 Y20 Z0.1"});
  EXPECT_THAT(Say("G30 P2 X20 Y215 Z0.1 S3").lines[0],
              HasSubstr("adjustments made: -0.100 -0.100 -0.100"));
}

// The published timing: 15 to 20 s for 3x3 touches, 45 to 60 s for 5x5.
TEST_F(BedProbingTest, GridsTakeAsLongAsPublished) {
  const auto grid_s = [&](int side) {
    SayAll({"G28", "G30 X20 Y20 S-1"});
    const double from_s = firmware_.machine_time_s();
    for (int i = 0; i < side * side; ++i) {
      const int column = i / side % 2 == 0 ? i % side : side - 1 - i % side;
      SayAll({"G30 X" + std::to_string(20 + 195 * column / (side - 1)) + " Y" +
              std::to_string(20 + 195 * (i / side) / (side - 1)) + " S-1"});
    }
    return firmware_.machine_time_s() - from_s;
  };

  const double three_s = grid_s(3), five_s = grid_s(5);

  EXPECT_GE(three_s, 15);
  EXPECT_LE(three_s, 20);
  EXPECT_GE(five_s, 45);
  EXPECT_LE(five_s, 60);
}

}  // namespace
}  // namespace caltwin
