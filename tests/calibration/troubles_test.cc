#include "calibration/loop/troubles.h"

#include <array>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/rng.h"

namespace caltwin {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using Touches = std::vector<double>;

// Ten touches of each of two faces, about 1 um of chance on top of `shape`.
std::vector<Touches> Faces(double (*shape)(int), std::uint64_t seed) {
  Rng rng(seed, 0, "touches");
  std::vector<Touches> faces_mm(2);
  for (Touches& face_mm : faces_mm) {
    for (int i = 0; i < 10; ++i) face_mm.push_back(shape(i) + 0.001 * rng.Normal());
  }
  faces_mm[1] = Touches(10, 0.3);  // The other face repeats exactly, elsewhere.
  return faces_mm;
}

Artefact Block() {
  return {.id = "block", .at_mm = {150, 150, 0}, .size_mm = {76.2, 50.8, 25.4}};
}

TEST(ProbeReadingOf, ReadsTheObjectModel) {
  const auto of = [](const char* result) {
    return ProbeReadingOf(std::array<std::string, 1>{
        std::string(R"({"key":"sensors.probes[0].value[0]","result":)") + result +
        "}"});
  };

  EXPECT_EQ(of("1000"), ProbeReading::kTriggered);
  EXPECT_EQ(of("0"), ProbeReading::kFree);
  EXPECT_EQ(of("null"), ProbeReading::kMissing);
  EXPECT_EQ(ProbeReadingOf(std::array<std::string, 1>{"ok"}), ProbeReading::kUnknown);
}

// Face at 111.9, the ball of 1 mm: it is met at 110.9.
TEST(FindContactAhead, SaysHowFarTheTargetLiesBehindTheFace) {
  const ProbeMove short_of{.from_mm = {90, 150, 12}, .target_mm = {106.9, 150, 12}};
  const ProbeMove beyond{.from_mm = {90, 150, 12}, .target_mm = {120.9, 150, 12}};
  const ProbeMove above{.from_mm = {90, 150, 40}, .target_mm = {106.9, 150, 40}};
  const ProbeMove down{.from_mm = {20, 20, 40}, .target_mm = {20, 20, -2}};

  const auto to_short = FindContactAhead({Block()}, short_of, 1);
  const auto to_beyond = FindContactAhead({Block()}, beyond, 1);
  const auto to_table = FindContactAhead({Block()}, down, 1);

  ASSERT_TRUE(to_short && to_beyond && to_table);
  EXPECT_EQ(to_short->feature, "block.left");
  EXPECT_NEAR(to_short->beyond_mm, -4, 1e-9);
  EXPECT_NEAR(to_beyond->after_mm, 20.9, 1e-9);
  EXPECT_NEAR(to_beyond->beyond_mm, 10, 1e-9);
  EXPECT_EQ(to_table->feature, "bed.top");
  EXPECT_FALSE(FindContactAhead({Block()}, above, 1));
}

TEST(WhyProbeFailed, NamesWhatTheProbeReadsAfterwards) {
  using End = FailedProbeMove::End;
  const auto why = [](End end, ProbeReading after) {
    return WhyProbeFailed({.end = end, .after = after});
  };

  EXPECT_THAT(why(End::kTriggeredBefore, ProbeReading::kMissing),
              HasSubstr("no probe configured"));
  EXPECT_THAT(why(End::kTriggeredBefore, ProbeReading::kTriggered),
              HasSubstr("lifted clear of everything"));
  EXPECT_THAT(why(End::kTriggeredBefore, ProbeReading::kFree),
              HasSubstr("the move began in contact"));
  EXPECT_THAT(why(End::kBent, ProbeReading::kFree), HasSubstr("does not arrive"));
  // A stylus that is bent and says so ran into something.
  EXPECT_EQ(why(End::kBent, ProbeReading::kTriggered), "");
  EXPECT_EQ(why(End::kNothingMet, ProbeReading::kUnknown), "");
}

TEST(WhyProbeFailed, ATargetShortOfTheFaceIsToldFromALostPlace) {
  FailedProbeMove failed{.after = ProbeReading::kFree,
                         .ahead = ContactAhead{"block.left", 20, -4}};
  EXPECT_THAT(WhyProbeFailed(failed), HasSubstr("ended 4.0 mm before"));
  failed.ahead->beyond_mm = 12;
  EXPECT_THAT(WhyProbeFailed(failed),
              AllOf(HasSubstr("stands elsewhere"), Not(HasSubstr("nor after homing"))));
  failed.was_tried_again = true;
  EXPECT_THAT(WhyProbeFailed(failed), HasSubstr("nor after homing"));
  failed.found_again_mm = 0.02;
  EXPECT_THAT(WhyProbeFailed(failed), HasSubstr("had lost its place"));
}

TEST(WhyInconsistent, TellsOrderFromChance) {
  const auto step = [](int i) {
    return i < 4 ? 0.0 : 0.08;
  };
  const auto drift = [](int i) {
    return -0.005 * i;
  };
  const auto chip = [](int i) {
    return i == 6 ? 0.1 : 0.0;
  };
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    EXPECT_THAT(WhyInconsistent(Faces(step, seed)),
                AllOf(HasSubstr("two levels, 0.0"), HasSubstr("from touch 5 on")));
    EXPECT_THAT(WhyInconsistent(Faces(drift, seed)), HasSubstr("they drift: -"));
    EXPECT_THAT(WhyInconsistent(Faces(chip, seed)), HasSubstr("one touch, the 7."));
  }
}

TEST(WhyInconsistent, ChanceIsRarelyTakenForOrder) {
  int in_no_order = 0;
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    Rng rng(seed, 0, "touches");
    std::vector<Touches> faces_mm(2);
    for (Touches& face_mm : faces_mm) {
      for (int i = 0; i < 10; ++i) face_mm.push_back(0.012 * rng.Normal());
    }
    const std::string words = WhyInconsistent(faces_mm);
    in_no_order += words.find("in no order") != std::string::npos ? 1 : 0;
  }

  EXPECT_GE(in_no_order, 498);
}

TEST(WhyInconsistent, FewTouchesTellNothing) {
  EXPECT_EQ(WhyInconsistent(std::vector<Touches>{{0, 0.1, 0.02}}), "");
}

TEST(WhyUnlikelySteps, NamesRatiosThatPartsMake) {
  EXPECT_THAT(WhyUnlikelySteps(640.0 / 800),
              HasSubstr("a lead of 5 mm where 4 is entered"));
  EXPECT_THAT(WhyUnlikelySteps(1000.0 / 800), HasSubstr("a lead of 4 mm where 5"));
  EXPECT_THAT(WhyUnlikelySteps(1600.0 / 800), HasSubstr("microsteps"));
  EXPECT_THAT(WhyUnlikelySteps(1 / 25.4), HasSubstr("inches"));
  EXPECT_EQ(WhyUnlikelySteps(700.0 / 800), "");
}

// Read with the entered radius R': delta + R' - R. Drawn 0.02, true 0.025 mm.
TEST(WhyUnlikelyPretravel, NamesBallAndBlock) {
  const UnlikelyPretravel diameter{.found_mm = 1.025,
                                   .drawn_mm = 0.02,
                                   .entered_radius_mm = 2,
                                   .entered_size_mm = 25.4};
  UnlikelyPretravel block{.found_mm = 0.525,
                          .drawn_mm = 0.02,
                          .entered_radius_mm = 1,
                          .entered_size_mm = 25.4};

  EXPECT_TRUE(IsUnlikely(diameter, 0.001));
  EXPECT_THAT(WhyUnlikelyPretravel(diameter), HasSubstr("diameter was entered"));
  block.calliper_size_mm = 24.4;
  EXPECT_THAT(WhyUnlikelyPretravel(block), HasSubstr("a calliper reads 24.400"));
  block.calliper_size_mm = 25.4;
  EXPECT_THAT(WhyUnlikelyPretravel(block), Not(HasSubstr("calliper")));
}

TEST(WhyUnlikelyPretravel, ADrawnPretravelIsLikely) {
  EXPECT_FALSE(IsUnlikely({.found_mm = 0.05, .drawn_mm = 0.02}, 0.001));
  EXPECT_FALSE(IsUnlikely({.found_mm = -0.002, .drawn_mm = 0.02}, 0.001));
  EXPECT_TRUE(IsUnlikely({.found_mm = -0.01, .drawn_mm = 0.02}, 0.001));
}

TEST(WhyWorse, ADoubledErrorIsASignAndARightValueWasRight) {
  EXPECT_THAT(WhyWorse(-0.25, -0.5, 0.001), HasSubstr("wrong sign"));
  EXPECT_THAT(WhyWorse(0.0005, 0.05, 0.001), HasSubstr("was right already"));
  EXPECT_EQ(WhyWorse(0.05, 0.15, 0.001), "");
}

TEST(WhyTooMuchCompensation, TwiceTheGapWasCountedTwice) {
  EXPECT_THAT(WhyTooMuchCompensation(0.1, -0.05), HasSubstr("counted twice"));
  EXPECT_THAT(WhyTooMuchCompensation(0.1, -0.02), Not(HasSubstr("twice")));
  EXPECT_EQ(WhyTooMuchCompensation(0.05, 0.01), "");
}

}  // namespace
}  // namespace caltwin
