#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/kinds/triple_z/missed_touch.h"
#include "calibration/kinds/triple_z/troubles.h"
#include "sim/base/rng.h"

namespace caltwin {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using Cause = OffPlane::Cause;

std::vector<BedTouch> Grid(int columns,
                           double sigma_mm,
                           std::uint64_t seed,
                           const std::function<double(double, double)>& shape) {
  Rng rng(seed, 0, "touches");
  std::vector<BedTouch> touches;
  for (int i = 0; i < columns; ++i) {
    for (int j = 0; j < columns; ++j) {
      const double x_mm = 20 + 200.0 * i / (columns - 1);
      const double y_mm = 20 + 200.0 * j / (columns - 1);
      touches.push_back({.at_mm = {x_mm, y_mm},
                         .height_mm = 0.004 * x_mm - 0.002 * y_mm + shape(x_mm, y_mm) +
                                      sigma_mm * rng.Normal()});
    }
  }
  return touches;
}

double Flat(double, double) {
  return 0;
}
double Bowl(double x_mm, double y_mm) {
  return 2e-5 * ((x_mm - 120) * (x_mm - 120) + (y_mm - 120) * (y_mm - 120));
}

// A tilted bed that is flat is called nothing, but for one in a hundred.
TEST(WhyOffPlane, AFlatBedIsCalledNothing) {
  int called = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    called += WhyOffPlane(Grid(3, 0.005, seed, Flat), 0.005) ? 1 : 0;
    called += WhyOffPlane(Grid(5, 0.005, seed, Flat), 0.005) ? 1 : 0;
  }

  EXPECT_LE(called, 8);
}

TEST(WhyOffPlane, ChipsUnderTheProbeAreOneTouch) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    auto touches = Grid(3, 0.005, seed, Flat);
    touches[5].height_mm += 0.3;

    const auto off = WhyOffPlane(touches, 0.005);

    ASSERT_TRUE(off);
    EXPECT_EQ(off->cause, Cause::kOneTouch);
    EXPECT_EQ(off->touch, 5u);
    EXPECT_NEAR(off->size_mm, 0.3, 0.05);
    EXPECT_THAT(off->words(), HasSubstr("something lies on the bed"));
  }
}

TEST(WhyOffPlane, AHollowBedIsBent) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const auto off = WhyOffPlane(Grid(5, 0.005, seed, Bowl), 0.005);

    ASSERT_TRUE(off);
    EXPECT_EQ(off->cause, Cause::kBent) << off->words();
    EXPECT_NEAR(off->size_mm, 0.4, 0.03);  // 2e-5 * 2 * 100^2.
    EXPECT_THAT(off->words(), HasSubstr("its middle low"));
  }
}

TEST(WhyOffPlane, TouchesThatDoNotRepeatHaveNoShape) {
  int scatter = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const auto off = WhyOffPlane(Grid(5, 0.1, seed, Flat), 0.005);
    scatter += off && off->cause == Cause::kScatter ? 1 : 0;
  }

  EXPECT_GE(scatter, 97);
}

TEST(WhyOffPlane, FourTouchesAreTooFewToTellWhy) {
  auto touches = Grid(2, 0, 1, Flat);
  EXPECT_FALSE(WhyOffPlane(touches, 0.005));
  touches[3].height_mm += 0.4;

  const auto off = WhyOffPlane(touches, 0.005);

  ASSERT_TRUE(off);
  EXPECT_EQ(off->cause, Cause::kFew);
  EXPECT_NEAR(off->size_mm, 0.2, 1e-9);  // +-0.1 at each corner, one degree of freedom.
}

// A chip 0.3 mm high that the first touch met, in closed form: the plane lies at 1 mm.
OffPlane Chip(double size_mm) {
  return {.cause = Cause::kOneTouch,
          .touch = 2,
          .size_mm = size_mm,
          .found = "found",
          .advice = "advice"};
}

TEST(WordsOfAgain, WhatStaysIsDebrisAndWhatHangsADent) {
  const std::vector<double> again_mm = {1.29, 1.30, 1.31};
  const std::vector<double> dent_mm = {0.69, 0.70, 0.71};

  EXPECT_THAT(WordsOfAgain(Chip(0.3), 1.3, again_mm),
              HasSubstr("lies 0.300 mm above: debris on the bed, not the probe"));
  EXPECT_THAT(WordsOfAgain(Chip(-0.3), 0.7, dent_mm),
              HasSubstr("lies 0.300 mm below: a dent in the bed"));
}

TEST(WordsOfAgain, WhatIsGoneWasABadTouchNotDebris) {
  const std::vector<double> again_mm = {1.00, 1.01, 0.99};

  const std::string words = WordsOfAgain(Chip(0.3), 1.3, again_mm);

  EXPECT_THAT(words, HasSubstr("that touch was bad"));
  EXPECT_THAT(words, Not(HasSubstr("debris")));
}

TEST(WordsOfAgain, WhatMovedHalfwayIsNotDecided) {
  const std::vector<double> again_mm = {1.15, 1.15, 1.15};

  EXPECT_EQ(WordsOfAgain(Chip(0.3), 1.3, again_mm), "found: advice");
}

TEST(WordsOfAgain, APlaceThatRepeatsAcquitsTheProbe) {
  const OffPlane off{.cause = Cause::kScatter, .size_mm = 0.1, .found = "found"};
  const std::vector<double> tight_mm = {1.000, 1.004, 0.996, 1.002};
  const std::vector<double> wide_mm = {1.0, 1.1, 0.9, 1.05};

  EXPECT_THAT(WordsOfAgain(off, 1, tight_mm), HasSubstr("it is the bed"));
  EXPECT_THAT(WordsOfAgain(off, 1, wide_mm), HasSubstr("it is the probe"));
}

TEST(WhyNotLevel, ScrewsThatDidAsToldAreNoTrouble) {
  EXPECT_EQ(WhyNotLevel({0.8, 0, 1.3}, {0.801, -0.001, 1.298}, 0.002), "");
  EXPECT_EQ(WhyNotLevel({0, 0, 0}, {0.001, 0, 0}, 0.002), "");
}

TEST(WhyNotLevel, WhatTheScrewsDidIsNamed) {
  const Vec3<double> told(0.8, 0.1, 1.3);
  const auto words = [&](double z1, double z2, double z3) {
    return WhyNotLevel(told, {z1, z2, z3}, 0.002);
  };

  EXPECT_THAT(words(0, 0, 0), HasSubstr("did not move"));
  EXPECT_THAT(words(-0.8, -0.1, -1.3), HasSubstr("the other way"));
  EXPECT_THAT(words(0.8, 0.1, 0), HasSubstr("z3 did not move"));
  EXPECT_THAT(words(1.3, 0.1, 0.8), HasSubstr("z1 and z3 are exchanged"));
  EXPECT_THAT(words(0.1, 0.8, 1.3), HasSubstr("z1 and z2 are exchanged"));
  EXPECT_THAT(words(0.1, 1.3, 0.8), HasSubstr("in a ring"));
}

// Half the way fits no single cause, and none is named.
TEST(WhyNotLevel, WhatFitsNothingIsNotNamed) {
  EXPECT_EQ(WhyNotLevel({0.8, 0.1, 1.3}, {0.4, 0.05, 0.65}, 0.002), "");
}

// Nine tenths of the tilt, and the middle in full: one more round leaves a hundredth.
TEST(WhyNotLevel, ABedThatFollowsInPartWantsAnotherRound) {
  const Vec3<double> told(0.9, -0.3, 0.6);  // Mean 0.4.
  const Vec3<double> moved(0.85, -0.23, 0.58);

  EXPECT_THAT(WhyNotLevel(told, moved, 0.002),
              AllOf(HasSubstr("tilted by 90 %"), HasSubstr("leaves 1 %")));
  EXPECT_EQ(WhyNotLevel(told, {0.85, -0.23, 0.2}, 0.002), "");
}

// z1 and z2 were told the same: who is exchanged cannot show.
TEST(WhyNotLevel, WhatLooksAlikeIsNotToldApart) {
  EXPECT_EQ(WhyNotLevel({0.5, 0.5, 0}, {0.5, 0.5, 0}, 0.002), "");
}

constexpr char kTriggered[] =
    "Error: Probe already triggered before probing move started";
constexpr char kNotTriggered[] = "Error: Probe was not triggered during probing move";

// A bed of 40 mrad along x: +8 mm at 200, the other corners at 0.
std::vector<BedTouch> Steep(double slope) {
  return {{{0, 0}, 0}, {{50, 0}, 50 * slope}, {{50, 50}, 50 * slope}, {{0, 50}, 0}};
}

TEST(WhyNoHeight, AProbeThatIsMissingIsNeitherStuckNorOpen) {
  EXPECT_THAT(WhyNoHeight({.reply = kNotTriggered, .clear = ProbeReading::kMissing}),
              HasSubstr("no probe configured"));
}

TEST(WhyNoHeight, AStuckProbeIsToldFromABedTooHighByTheLoweredBed) {
  const auto touches = Steep(0.04);
  MissedTouch missed{.reply = kTriggered,
                     .at_mm = {200, 0},
                     .clear = ProbeReading::kTriggered,
                     .before = touches};

  EXPECT_THAT(WhyNoHeight(missed), HasSubstr("shorted or its pin inverted"));
  missed.clear = ProbeReading::kFree;
  EXPECT_THAT(WhyNoHeight(missed),
              AllOf(HasSubstr("stands too high at (200, 0)"),
                    HasSubstr("foretells +8.0 mm"),
                    Not(HasSubstr("shorted"))));
}

TEST(WhyNoHeight, ABedTooLowIsToldByThePlaneOfTheOthers) {
  const auto low = Steep(-0.04), flat = Steep(0.001);
  MissedTouch missed{.reply = kNotTriggered,
                     .at_mm = {200, 0},
                     .clear = ProbeReading::kFree,
                     .before = low};

  EXPECT_THAT(WhyNoHeight(missed),
              AllOf(HasSubstr("lies too low"), HasSubstr("foretells -8.0 mm")));
  missed.before = flat;
  EXPECT_THAT(WhyNoHeight(missed), HasSubstr("triggered 4 times and then not"));
  missed.before = {};
  EXPECT_THAT(WhyNoHeight(missed), HasSubstr("Push the probe by hand"));
}

}  // namespace
}  // namespace caltwin
