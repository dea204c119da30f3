#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/firmware/kinds/delta/marlin.h"
#include "sim/machine/kinds/delta/model.h"
#include "tests/firmware/delta_bed.h"

namespace caltwin {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class MarlinDeltaTest : public ::testing::Test {
 protected:
  std::vector<std::string> Lines(std::string_view line) {
    return marlin_.Execute(line).lines;
  }

  DeltaModel<double> drawn_ = SymmetricDelta(300, 130, 250);
  DeltaBedPlant bed_{drawn_, /*bed_mm=*/0.25, /*steps_per_mm=*/8000};
  MarlinDelta marlin_{drawn_, drawn_, {8000, 8000, 8000}, &bed_, {}};
};

TEST_F(MarlinDeltaTest, HomesBeforeItProbes) {
  EXPECT_TRUE(marlin_.Execute("G30 X0 Y0").error);
  EXPECT_THAT(
      Lines("G28"),
      ElementsAre("X:0.00 Y:0.00 Z:300.00 E:0.00 Count A:4108333 B:4108333 C:4108333"));
  EXPECT_THAT(Lines("G30 X10 Y-20"), ElementsAre("Bed X: 10.00 Y: -20.00 Z: 0.250"));
  EXPECT_EQ(marlin_.touches(), 1);
  EXPECT_GT(marlin_.machine_time_s(), 0);
}

TEST_F(MarlinDeltaTest, PutsTheTipWhereItIsToTouch) {
  Lines("G28");
  EXPECT_THAT(Lines("M851 X12 Y-5 Z-2.5"),
              ElementsAre("Probe Offset X12.00 Y-5.00 Z-2.50"));
  EXPECT_THAT(Lines("G30 X10 Y-20"), ElementsAre("Bed X: 10.00 Y: -20.00 Z: -2.250"));
  // The nozzle stands beside, clear of the bed.
  EXPECT_THAT(Lines("M114")[0], HasSubstr("X:-2.00 Y:-15.00 Z:5.25"));
  EXPECT_THAT(Lines("M851 Z-21"), ElementsAre("?Z out of range (-20 to 20)"));
  EXPECT_THAT(Lines("M503"), Contains("echo:  M851 X12.00 Y-5.00 Z-2.50"));
}

// A carriage backs off by M666 from its endstop to where the nozzle stands at H.
TEST_F(MarlinDeltaTest, CarriagesBackOffFromTheirEndstops) {
  Lines("M666 X-0.15 Y-0.65 Z0.2");
  Lines("M665 H300.45 R130.8 X0.35 Y-0.25");

  EXPECT_DOUBLE_EQ(marlin_.settings().endstop_mm[0], 300.60);
  EXPECT_DOUBLE_EQ(marlin_.settings().endstop_mm[1], 301.10);
  EXPECT_DOUBLE_EQ(marlin_.settings().endstop_mm[2], 300.45);
  EXPECT_THAT(Lines("M503"),
              ElementsAre("echo:  G21    ; Units in mm (mm)",
                          "echo:  M665 L250.0000 R130.8000 H300.4500 S200.00 X0.3500 "
                          "Y-0.2500 Z0.0000 A0.0000 B0.0000 C0.0000",
                          "echo:  M666 X-0.1500 Y-0.6500 Z0.0000",
                          "echo:  M851 X0.00 Y0.00 Z0.00"));
}

// "Lnan" reads as a bare L, and would silently set nothing.
TEST_F(MarlinDeltaTest, NamesALetterWithoutItsNumber) {
  EXPECT_THAT(Lines("M665 Lnan"),
              ElementsAre("?M665: no number after L, nothing is changed"));
  EXPECT_THAT(Lines("M666 Xinf Y-0.1"),
              ElementsAre("?M666: no number after X, nothing is changed"));
  EXPECT_THAT(Lines("G33 Pnan"),
              ElementsAre("?G33: no number after P, nothing is changed"));
  EXPECT_THAT(Lines("M503"), Contains("echo:  M666 X0.0000 Y0.0000 Z0.0000"));
}

TEST_F(MarlinDeltaTest, StoresRestoresAndForgets) {
  Lines("M665 R131");
  Lines("M500");
  Lines("M665 R132");
  Lines("M501");
  EXPECT_DOUBLE_EQ(marlin_.settings().radius_mm[2], 131);
  Lines("M502");
  EXPECT_DOUBLE_EQ(marlin_.settings().radius_mm[2], 130);
}

TEST_F(MarlinDeltaTest, KeepsAMeshOnceSwitchedOn) {
  EXPECT_FALSE(marlin_.Execute("M421 I6 J0 Z0.125").error);
  EXPECT_EQ(marlin_.mesh().nodes, 0);
  EXPECT_THAT(Lines("M420 S1"), Contains("echo:Bed Leveling ON"));
  EXPECT_DOUBLE_EQ(marlin_.mesh().Lift_mm(100, -100), 0.125);
  EXPECT_DOUBLE_EQ(marlin_.mesh().Lift_mm(0, 0), 0);
  EXPECT_TRUE(marlin_.Execute("M421 I7 J0 Z0.1").error);
  EXPECT_TRUE(marlin_.Execute("M421 I1 J0").error);
}

TEST_F(MarlinDeltaTest, RefusesRodsThatDoNotReach) {
  EXPECT_TRUE(marlin_.Execute("M665 L100").error);
  EXPECT_DOUBLE_EQ(marlin_.settings().arm_mm[0], 250);
  Lines("G28");
  EXPECT_TRUE(marlin_.Execute("G1 X400").error);
  EXPECT_TRUE(marlin_.Execute("G1 Z320").error);  // Above the endstops.
}

TEST_F(MarlinDeltaTest, MovesByAsMuchAfterG91) {
  Lines("G28");
  Lines("G1 X10 Y-5 Z20");
  Lines("G91");
  Lines("G1 X5 Z2");
  EXPECT_THAT(Lines("M114")[0], HasSubstr("X:15.00 Y:-5.00 Z:22.00"));
  Lines("G90");
  Lines("G1 X5");
  EXPECT_THAT(Lines("M114")[0], HasSubstr("X:5.00 Y:-5.00 Z:22.00"));
}

TEST_F(MarlinDeltaTest, RefusesWhatWouldSendLaterMovesElsewhere) {
  EXPECT_THAT(Lines("G92 X0"), ElementsAre("Error:G92 is not part of this machine"));
  EXPECT_TRUE(marlin_.Execute("G20").error);
  EXPECT_TRUE(marlin_.Execute("G2 X10 I5").error);
  EXPECT_FALSE(marlin_.Execute("G92 E0").error);
}

TEST_F(MarlinDeltaTest, AnswersWhatItDoesNotKnowAsMarlinDoes) {
  EXPECT_THAT(Lines("M5000"), ElementsAre("echo:Unknown command: \"M5000\""));
  EXPECT_THAT(Lines("M115")[0], HasSubstr("FIRMWARE_NAME:Marlin"));
  EXPECT_FALSE(marlin_.Execute("M400").error);
}

}  // namespace
}  // namespace caltwin
