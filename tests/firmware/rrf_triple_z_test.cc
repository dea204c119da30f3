#include "sim/firmware/dialects/rrf_triple_z.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/machine/kinds/triple_z/drawing.h"

namespace caltwin {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

const Pivots<double> kPivots_mm = TripleZDrawing{}.pivots_mm();

// A flat bed that rises by 2 mrad along x, its screws where they are drawn.
class TiltedBed : public TripleZPlant {
 public:
  std::optional<double> Touch(const Vec3<double>& raised_mm,
                              double x_mm,
                              double y_mm) override {
    if (x_mm > 230) return std::nullopt;
    return 0.002 * x_mm + ScrewWeights<double>(kPivots_mm, x_mm, y_mm).dot(raised_mm);
  }
};

class RrfTripleZTest : public ::testing::Test {
 protected:
  Reply Say(const std::string& line) { return firmware_.Execute(line); }
  // Whatever was asked for is done without complaint.
  void SayAll(const std::vector<std::string>& lines) {
    for (const std::string& line : lines) {
      const Reply reply = Say(line);
      EXPECT_FALSE(reply.error) << line << ": " << reply.lines.back();
    }
  }
  TiltedBed bed_;
  RrfTripleZ firmware_{{.pivots_mm = kPivots_mm}, &bed_};
};

TEST_F(RrfTripleZTest, SaysAtWhichHeightTheProbeStopped) {
  SayAll({"G28"});

  EXPECT_THAT(Say("G30 X125 Y50 S-1").lines, ElementsAre("Stopped at height 0.250 mm"));
}

TEST_F(RrfTripleZTest, MovesADriverAloneThroughItsOwnAxis) {
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
TEST_F(RrfTripleZTest, NewAxesAreNotHomedBeforeG92) {
  SayAll({"G28", "G1 Z10", "M584 Z0 U1 V2 P5"});

  EXPECT_TRUE(Say("G1 U9").error);
  EXPECT_THAT(Say("M114").lines[0], HasSubstr("Z:10.000 U:0.000 V:0.000"));
  EXPECT_FALSE(Say("G92 U10").error);
  EXPECT_FALSE(Say("G1 U9").error);
  EXPECT_TRUE(Say("G1 V9").error);
}

TEST_F(RrfTripleZTest, RefusesNumbersThatAreNone) {
  SayAll({"G28"});

  EXPECT_TRUE(Say("M92 Z0").error);
  EXPECT_TRUE(Say("M671 Xnan:1:2 Y1:2:3").error);
  EXPECT_THAT(Say("G30 X125 Y50 S-1").lines, ElementsAre("Stopped at height 0.250 mm"));
}

TEST_F(RrfTripleZTest, LevelsByItsDriversAsRepRapFirmwareSaysIt) {
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

TEST_F(RrfTripleZTest, RefusesCorrectionsBeyondItsLimit) {
  SayAll({"M671 S0.1", "G28", "G30 P0 X20 Y20 Z-99999", "G30 P1 X215 Y20 Z-99999"});

  const Reply reply = Say("G30 P2 X20 Y215 Z-99999 S3");

  EXPECT_TRUE(reply.error);
  EXPECT_THAT(reply.lines[0], HasSubstr("exceed configured limit of 0.10mm"));
  EXPECT_LT(firmware_.raised_mm().norm(), 1e-9);
}

TEST_F(RrfTripleZTest, NamesWhatItDoesNotDo) {
  EXPECT_THAT(Say("G30 X20 Y20").lines[0], HasSubstr("insufficient axes homed"));
  SayAll({"G28"});
  EXPECT_THAT(Say("G30 X232 Y20 S-1").lines,
              ElementsAre("Error: Probe was not triggered during probing move"));
  EXPECT_THAT(Say("G1 X236").lines[0], HasSubstr("outside machine limits"));
  EXPECT_THAT(Say("G1 U5").lines[0], HasSubstr("no axes U and V"));
  EXPECT_THAT(Say("G31 X20").lines[0], HasSubstr("G31 is not known"));
  EXPECT_THAT(Say("M584 Z0:2 U1").lines[0], HasSubstr("M584"));
}

TEST_F(RrfTripleZTest, KeepsScrewsAsTheyAreSet) {
  SayAll({"M671 X30:200:30 Y25:25:210 S5"});

  EXPECT_THAT(Say("M671").lines,
              ElementsAre("leadscrews at (30.0, 25.0), (200.0, 25.0), (30.0, 210.0), "
                          "maximum correction 5.00mm"));
}

TEST_F(RrfTripleZTest, ProbesWithinItsTravelAlone) {
  firmware_.Execute("G28");

  EXPECT_TRUE(firmware_.Execute("G30 X9999 Y20 S-1").error);
  EXPECT_TRUE(firmware_.Execute("G30 Xfoo S-1").error);
  EXPECT_TRUE(firmware_.Execute("M671 S-3").error);
  EXPECT_FALSE(firmware_.Execute("G30 X230 Y20 S-1").error);
}

// The published timing: 15 to 20 s for 3x3 touches, 45 to 60 s for 5x5.
TEST_F(RrfTripleZTest, GridsTakeAsLongAsPublished) {
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
