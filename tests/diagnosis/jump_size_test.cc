#include "calibration/diagnosis/jump_size.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace caltwin {
namespace {

using ::testing::HasSubstr;

// A screw of 4 mm, 200 full steps a turn: an electrical turn is 80 um.
std::string RemarkOn(double jump_um, double sd_um) {
  Machine machine;
  machine.axes[0].lead_mm = 4;
  machine.axes[0].full_steps_per_rev = 200;
  return RemarkOnJump(machine,
                      {.cause = "missed_steps",
                       .axis = "x",
                       .parameters = {{"jump_um", jump_um, sd_um}}});
}

TEST(RemarkOnJump, WholeElectricalTurnsAreTheMotors) {
  EXPECT_EQ(RemarkOn(80.4, 1), "");
  EXPECT_EQ(RemarkOn(-243, 2), "");
}

TEST(RemarkOnJump, AnyOtherSizeMayBeAGaugeSetAnew) {
  EXPECT_THAT(RemarkOn(23, 1), HasSubstr("23 +- 1 um is no whole number"));
  EXPECT_THAT(RemarkOn(-120, 1), HasSubstr("gauge set anew"));
}

TEST(RemarkOnJump, WhatIsHardlyKnownMayBeWhole) {
  EXPECT_EQ(RemarkOn(60, 10), "");
}

TEST(RemarkOnJump, OtherFindingsHaveNone) {
  EXPECT_EQ(RemarkOnJump({}, {.cause = "unknown", .axis = "x"}), "");
}

}  // namespace
}  // namespace caltwin
