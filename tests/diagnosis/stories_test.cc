// What a name must beat, and which findings can take up each other's rest.
#include "calibration/diagnosis/stories.h"

#include <gtest/gtest.h>

namespace caltwin {
namespace {

Candidate Seen(const char* channel, std::vector<std::string> covariates) {
  Candidate candidate;
  candidate.shown = {channel, std::move(covariates)};
  return candidate;
}

TEST(Stories, AProbeMustBeSeenAlongMoreThanOneAxis) {
  const Candidate warm = Seen("probe", {"temp"});
  EXPECT_GT(MarginOver(warm, Seen("x", {"dir_x", "t"})),
            MarginOver(warm, Seen("probe", {"t"})));
}

TEST(Stories, WhatWarmsMustFollowTheThermometerNotOnlyTheClock) {
  const Candidate screw = Seen("x", {"temp", "x"});
  const double usual = MarginOver(screw, Seen("x", {"x", "temp"}));
  EXPECT_GT(MarginOver(screw, Seen("x", {"x", "t"})), usual);
  EXPECT_DOUBLE_EQ(MarginOver(screw, Seen("y", {"x", "t"})), usual);
  EXPECT_DOUBLE_EQ(MarginOver(Seen("z", {"temp"}), Seen("z", {"t"})), usual);
}

TEST(Stories, ProbeAndAxisShareRowsTimeAndTemperatureAVariable) {
  const Shown probe{"probe", {"temp"}};
  EXPECT_TRUE(ShareRowsAndVariable(probe, {"x", {"x", "t"}}));
  EXPECT_TRUE(ShareRowsAndVariable({"bed", {"temp"}}, {"z", {"t"}}));
  EXPECT_FALSE(ShareRowsAndVariable(probe, {"x", {"x", "y"}}));
  EXPECT_FALSE(ShareRowsAndVariable({"x", {"t"}}, {"y", {"t"}}));
  EXPECT_FALSE(ShareRowsAndVariable({"bed", {"x"}}, {"x", {"x"}}));
}

// On a delta a tower's carriage stands where the place wants it; a screw under a bed
// does not.
TEST(Stories, ATowersTravelIsPlace) {
  EXPECT_TRUE(ShareRowsAndVariable({"c", {"motor_c"}}, {"z", {"x", "y"}}));
  EXPECT_TRUE(ShareRowsAndVariable({"bed", {"x"}}, {"a", {"motor_a"}}));
  EXPECT_TRUE(ShareRowsAndVariable({"a", {"motor_a"}}, {"b", {"motor_b"}}));
  EXPECT_FALSE(ShareRowsAndVariable({"c", {"t"}}, {"z", {"x", "y"}}));
  EXPECT_FALSE(ShareRowsAndVariable({"z3", {"motor_c"}}, {"z", {"x", "y"}}));
}

TEST(Stories, TheSenseAloneIsNoSharedVariable) {
  EXPECT_FALSE(ShareRowsAndVariable({"x", {"load", "dir_x"}}, {"x", {"dir_x", "x"}}));
}

}  // namespace
}  // namespace caltwin
