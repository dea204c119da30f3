#include "sim/controllers/linuxcnc/config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace caltwin {
namespace linuxcnc {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(LinuxCncIni, AValueTakesThePlaceOfTheOneThatWasThere) {
  EXPECT_EQ(WithIniValue("[A]\nK = 1\nL = 2\n[B]\nK = 3\n", "A", "K", "9"),
            "[A]\nK = 9\nL = 2\n[B]\nK = 3\n");
}

TEST(LinuxCncIni, AMissingKeyIsAddedToItsSection) {
  EXPECT_EQ(WithIniValue("[A]\n[B]\nK = 3\n", "A", "K", "9"),
            "[A]\nK = 9\n[B]\nK = 3\n");
}

TEST(LinuxCncIni, AMissingSectionIsAddedAtTheEnd) {
  EXPECT_EQ(WithIniValue("[B]\nK = 3\n", "A", "K", "9"), "[B]\nK = 3\n\n[A]\nK = 9\n");
}

// LinuxCNC takes the first of a section that stands twice.
TEST(LinuxCncIni, OfValuesThatStandTwiceOneIsLeft) {
  EXPECT_EQ(WithIniValue("[A]\nK = 1\nK=2\n[A]\n  K  =  3\n", "A", "K", "9"),
            "[A]\nK = 9\n[A]\n");
}

TEST(LinuxCncIni, AKeyOfALongerNameIsAnother) {
  const std::string ini =
      WithIniValue("[A]\nHOME = 1\nHOME_OFFSET = 2\n", "A", "HOME", "9");
  EXPECT_THAT(ini, HasSubstr("HOME_OFFSET = 2"));
  EXPECT_THAT(ini, Not(HasSubstr("HOME = 1")));
}

TEST(LinuxCncIni, AnAxisThatHomesAtItsTopMeetsItsSwitchUpwards) {
  const std::string ini = IniText(
      {.name = "m",
       .joints =
           {{.min_mm = 0, .max_mm = 100, .home_mm = 100, .is_home_at_min = false}}},
      "axis");
  EXPECT_THAT(ini,
              HasSubstr("HOME_OFFSET = 100\nHOME = 98\nHOME_SEARCH_VEL = 10\n"
                        "HOME_LATCH_VEL = 0.5\n"));
}

TEST(LinuxCncIni, TwoJointsOfOneAxisHomeTogether) {
  const std::string ini =
      IniText({.name = "m",
               .kinematics = "trivkins coordinates=XYY kinstype=BOTH",
               .coordinates = "XYY",
               .axes = {{.letter = 'X'}, {.letter = 'Y'}},
               .joints = {{},
                          {.motor = 1, .home_sequence = -2},
                          {.motor = 2, .home_sequence = -2}}},
              "axis");
  EXPECT_THAT(
      ini,
      HasSubstr("JOINTS = 3\nKINEMATICS = trivkins coordinates=XYY kinstype=BOTH"));
  EXPECT_THAT(ini, HasSubstr("COORDINATES = XYY\n"));
  EXPECT_THAT(ini, HasSubstr("HOME_SEQUENCE = -2\n"));
}

TEST(LinuxCncIni, SaysWhatItHas) {
  const std::string ini = "[A]\nK = 1\n# L = 2\n[B]\n  M=3\n[A]\nK = 4\nN = 5\n";
  EXPECT_THAT(IniSections(ini), testing::ElementsAre("A", "B"));
  EXPECT_THAT(IniKeys(ini, "A"), testing::ElementsAre("K", "N"));
  EXPECT_THAT(IniKeys(ini, "C"), testing::IsEmpty());
  EXPECT_FALSE(IniIncludes(ini));
  EXPECT_TRUE(IniIncludes("#INCLUDE axes.inc\n" + ini));
}

TEST(LinuxCncHal, AJointHasThePinsOfItsMotor) {
  const std::string hal = HalText({.kinematics = "lineardeltakins",
                                   .joints = {{.motor = 2}, {.motor = 0}},
                                   .sizes = {{"R", 130}}},
                                  "mill");
  EXPECT_THAT(hal, HasSubstr("joint.0.motor-pos-cmd => caltwin.position-cmd-2\n"));
  EXPECT_THAT(hal, HasSubstr("setp caltwin.scale-0 [JOINT_1]SCALE\n"));
  EXPECT_THAT(hal, HasSubstr("setp lineardeltakins.R [KINS]R\n"));
  EXPECT_THAT(hal, HasSubstr("loadrt caltwin page=mill\n"));
}

}  // namespace
}  // namespace linuxcnc
}  // namespace caltwin
