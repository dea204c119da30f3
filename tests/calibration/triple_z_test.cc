// Triple Z: the published formulas and samples, what single screws tell, the loop's
// gain.

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/kinds/triple_z/procedures.h"
#include "calibration/kinds/triple_z/troubles.h"
#include "sim/base/rng.h"
#include "sim/effects/drive.h"
#include "sim/machine/kinds/triple_z/drawing.h"

namespace caltwin {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const Pivots<double> kDrawn_mm = TripleZDrawing{}.pivots_mm();

// The manual example's three readings over the screws.
BedPlane ManualExample() {
  return FitBedPlane(
      std::vector<BedTouch>{{{20, 20}, 9.23}, {{215, 20}, 11.68}, {{20, 215}, 10.35}},
      0.01);
}

void ExpectNear(const Vec3<double>& found, const Vec3<double>& expected) {
  EXPECT_LT((found - expected).norm(), 1e-9) << found.transpose();
}

TEST(BedPlane, AnglesAreArctangents) {
  BedPlane plane;
  plane.fit.slope_x.value = 0.001234;
  plane.fit.slope_y.value = -0.000567;

  EXPECT_NEAR(plane.TiltX_deg(), 0.0707, 1e-4);  // Not the sample's 0.32.
  EXPECT_NEAR(plane.TiltY_deg(), -0.0325, 1e-4);
  EXPECT_NEAR(plane.Tilt_deg(), 0.0778, 1e-4);
}

TEST(ScrewOffsets, OfTheManualExampleByItsFormulaAndByItsSample) {
  const BedPlane plane = ManualExample();

  ExpectNear(ScrewOffsets_mm(plane, kDrawn_mm, 10, OffsetRule::kFormula),
             {2.45, 0, 1.33});
  ExpectNear(ScrewOffsets_mm(plane, kDrawn_mm, 10, OffsetRule::kExample),
             {0, 2.45, 1.12});
  ExpectNear(ScrewOffsets_mm(plane, kDrawn_mm, 10, OffsetRule::kLevel),
             {0.77, -1.68, -0.35});
}

// reference_height cancels in the normalisation: that control does nothing.
TEST(ScrewOffsets, OfTheFormulaDoNotKnowTheReference) {
  const BedPlane plane = ManualExample();

  ExpectNear(ScrewOffsets_mm(plane, kDrawn_mm, 25, OffsetRule::kFormula),
             ScrewOffsets_mm(plane, kDrawn_mm, 10, OffsetRule::kFormula));
}

TEST(PlaneVerdicts, SayThatThreePointsFitAnyPlane) {
  EXPECT_THAT(PlaneVerdicts(ManualExample()),
              ElementsAre(HasSubstr("a residual of 0 says nothing")));
}

TEST(HighResidual, AsPublishedIsTheListOfRemedies) {
  std::vector<BedTouch> touches;
  for (int i = 0; i < 9; ++i) {
    const int across = i % 3, up = i / 3;
    touches.push_back({{20.0 + 90 * across, 20.0 + 90 * up}, i == 4 ? -0.9 : 0});
  }

  EXPECT_THAT(HighResidualAsPublished(FitBedPlane(touches, 0.01)),
              HasSubstr("debris on the bed"));
}

TEST(LevelReport, StatesThePublishedFigures) {
  const LevelReport report = ReportLevel(
      std::vector<BedTouch>{{{0, 0}, 10.089}, {{9, 0}, 10.03}, {{0, 9}, 9.984}}, 10);

  EXPECT_NEAR(report.mean_mm, 0.045, 1e-9);
  EXPECT_NEAR(report.max_mm, 0.089, 1e-9);
  // The population's, as the published 0.032 of a maximum of 0.089 must be.
  EXPECT_NEAR(report.std_mm, 0.0316, 1e-4);
  EXPECT_EQ(report.count, 3);
}

/// A bed in closed form: where its screws stand, who turns them, how it is tilted.
struct ToyBed {
  Pivots<double> standing_mm = kDrawn_mm;
  std::array<int, 3> screw_of = {0, 1, 2};
  double noise_mm = 0;
  double held_mm2 = 0;
  Rng rng{1, 0, "toy_bed"};

  Vec3<double> WeightsAt(const Eigen::Vector2d& at_mm) const {
    return ScrewWeights<double>(standing_mm, at_mm[0], at_mm[1]) -
           WeightsHeldBack<double>(standing_mm, held_mm2, at_mm);
  }

  std::vector<BedTouch> TouchAll(const Vec3<double>& raised_mm) {
    Vec3<double> screws_mm;
    for (int i = 0; i < 3; ++i) {
      screws_mm[screw_of[static_cast<std::size_t>(i)]] = raised_mm[i];
    }
    std::vector<BedTouch> touches;
    for (int i = 0; i < 9; ++i) {
      const int across = i % 3, up = i / 3;
      const Eigen::Vector2d at_mm(20 + 97.5 * across, 20 + 97.5 * up);
      const double height_mm = 0.004 * at_mm[0] - 0.7 + 2e-6 * at_mm.squaredNorm() +
                               WeightsAt(at_mm).dot(screws_mm) +
                               noise_mm * rng.Normal();
      touches.push_back({at_mm, height_mm});
    }
    return touches;
  }

  std::vector<RaisedTouches> OneByOne(double up_mm) {
    std::vector<RaisedTouches> stands;
    stands.push_back({Vec3<double>::Zero(), TouchAll(Vec3<double>::Zero())});
    for (int i = 0; i < 3; ++i) {
      const Vec3<double> raised_mm = up_mm * Vec3<double>::Unit(i);
      stands.push_back({raised_mm, TouchAll(raised_mm)});
    }
    return stands;
  }
};

TEST(ScrewResponse, TellsWiringAndPivots) {
  ToyBed bed;
  bed.standing_mm[1] += Eigen::Vector2d(-25, 18);
  bed.screw_of = {2, 1, 0};

  const ScrewResponse response = FitScrewResponse(bed.OneByOne(1), kDrawn_mm, 0.001);

  ASSERT_TRUE(response.is_told);
  EXPECT_EQ(response.screw_of, (std::array<int, 3>{2, 1, 0}));
  for (std::size_t i = 0; i < 3; ++i) {
    const auto screw = static_cast<std::size_t>(bed.screw_of[i]);
    EXPECT_LT((response.at_mm[i] - bed.standing_mm[screw]).norm(), 1e-6);
  }
  EXPECT_THAT(
      WordsOfResponse(response, kDrawn_mm),
      ElementsAre("Z1 and Z3 are swapped",
                  HasSubstr("pivot 2 is 30.8 +- 0.1 mm off (dx -25.0, dy +18")));
}

// All six ways to plug three motors in, two of them rings.
TEST(ScrewResponse, TellsEveryWiring) {
  const std::vector<std::pair<std::array<int, 3>, std::string>> wirings = {
      {{0, 1, 2}, "wiring and pivots are as drawn"},
      {{1, 0, 2}, "Z1 and Z2 are swapped"},
      {{2, 1, 0}, "Z1 and Z3 are swapped"},
      {{0, 2, 1}, "Z2 and Z3 are swapped"},
      {{1, 2, 0}, "the drivers of Z1, Z2, Z3 turn screws 2, 3, 1"},
      {{2, 0, 1}, "the drivers of Z1, Z2, Z3 turn screws 3, 1, 2"}};
  for (const auto& [screw_of, words] : wirings) {
    ToyBed bed{.screw_of = screw_of};
    const ScrewResponse response = FitScrewResponse(bed.OneByOne(1), kDrawn_mm, 0.001);

    ASSERT_TRUE(response.is_told);
    EXPECT_EQ(response.screw_of, screw_of);
    EXPECT_THAT(WordsOfResponse(response, kDrawn_mm), ElementsAre(words));
  }
}

TEST(ScrewResponse, StatesTheScatterOfRepeats) {
  constexpr int kRepeats = 200;
  constexpr double kNoise_mm = 0.01;
  ToyBed bed{.noise_mm = kNoise_mm};
  double squares = 0, variance = 0;
  for (int i = 0; i < kRepeats; ++i) {
    const auto response = FitScrewResponse(bed.OneByOne(1), kDrawn_mm, kNoise_mm);
    squares += (response.at_mm[1] - kDrawn_mm[1]).squaredNorm() / kRepeats;
    variance += response.at_sd_mm[1].squaredNorm() / kRepeats;
  }

  // A variance of 400 numbers scatters by 7 %; 4 of that.
  EXPECT_NEAR(squares / variance, 1, 0.28);
}

// Four grids of nine touches less twelve unknowns; a stated noise that holds has none.
TEST(ScrewResponse, ScatterOfTheTouchesHasTheirDegreesOfFreedom) {
  ToyBed bed{.noise_mm = 0.03};
  const auto stands = bed.OneByOne(1);

  EXPECT_EQ(FitScrewResponse(stands, kDrawn_mm, 0.01).dof, 4 * 9 - 12);
  EXPECT_TRUE(std::isinf(FitScrewResponse(stands, kDrawn_mm, 0.03).dof));
}

// Screws that all move alike say nothing of where they stand.
TEST(ScrewResponse, SaysWhenMovesDoNotTellIt) {
  ToyBed bed;
  std::vector<RaisedTouches> stands;
  for (const double up_mm : {0.0, 1.0, 2.0}) {
    const Vec3<double> raised_mm = Vec3<double>::Constant(up_mm);
    stands.push_back({raised_mm, bed.TouchAll(raised_mm)});
  }

  const auto response = FitScrewResponse(stands, kDrawn_mm, 0.01);

  EXPECT_FALSE(response.is_told);
  EXPECT_THAT(WordsOfResponse(response, kDrawn_mm),
              Contains(HasSubstr("raise single screws")));
}

// Held by guides as stiff as h, every pivot seems (K + h) K^-1 times as far out.
TEST(ScrewResponse, AHeldBedsPivotsSeemFurtherOut) {
  ToyBed bed{.noise_mm = 0.002, .held_mm2 = 3000};
  bed.screw_of = {1, 0, 2};

  const auto response = FitScrewResponse(bed.OneByOne(2), kDrawn_mm, 0.002);

  const auto held = HeldBedLike(response, kDrawn_mm);
  ASSERT_TRUE(held.has_value());
  EXPECT_NEAR(held->stiffness_ratio_mm2, 3000, 4 * held->sd_mm2);
  EXPECT_LT(held->sd_mm2, 60);
  // K^-1 d_3 = (0, 1 / 195 mm): by hand.
  EXPECT_NEAR(response.at_mm[2][1] - kDrawn_mm[2][1], 3000 / 195.0, 1);
  EXPECT_THAT(WordsOfResponse(response, kDrawn_mm),
              Contains(HasSubstr("guides hold the bed level against them")));
}

TEST(ScrewResponse, OtherPivotsAreNoHeldBed) {
  for (const Eigen::Vector2d& off_mm : {Eigen::Vector2d(0, 0), Eigen::Vector2d(9, 0)}) {
    ToyBed bed{.noise_mm = 0.002};
    bed.standing_mm[1] += off_mm;
    const auto response = FitScrewResponse(bed.OneByOne(2), kDrawn_mm, 0.002);
    EXPECT_FALSE(HeldBedLike(response, kDrawn_mm).has_value()) << off_mm[0];
  }
}

// Simulated 400 times: the stated standard deviation is that of the ratio found.
TEST(ScrewResponse, AHeldBedsStiffnessScattersAsStated) {
  constexpr int kRepeats = 400;
  constexpr double kNoise_mm = 0.002, kHeld_mm2 = 3000;
  ToyBed bed{.noise_mm = kNoise_mm, .held_mm2 = kHeld_mm2};
  double squares = 0, variance = 0;
  int found = 0;
  for (int i = 0; i < kRepeats; ++i) {
    const auto response = FitScrewResponse(bed.OneByOne(2), kDrawn_mm, kNoise_mm);
    const auto held = HeldBedLike(response, kDrawn_mm);
    if (!held) continue;
    ++found;
    squares += std::pow(held->stiffness_ratio_mm2 - kHeld_mm2, 2);
    variance += held->sd_mm2 * held->sd_mm2;
  }

  EXPECT_GT(found, 380);
  EXPECT_NEAR(squares / variance, 1, 0.28);
}

TEST(LevellingGain, IsNoughtWhereScrewsAreAsBelieved) {
  EXPECT_LT(SpectralRadius(LevellingGain(kDrawn_mm, kDrawn_mm)), 1e-12);
}

TEST(LevellingGain, OfTwoSwappedMotorsIsTwo) {
  const Pivots<double> swapped = {kDrawn_mm[1], kDrawn_mm[0], kDrawn_mm[2]};

  EXPECT_NEAR(SpectralRadius(LevellingGain(swapped, kDrawn_mm)), 2, 1e-12);
}

// The heights over the believed screws after a round are those before, times the gain.
TEST(LevellingGain, IsWhatARoundDoes) {
  ToyBed bed;
  bed.standing_mm[2] += Eigen::Vector2d(30, -60);
  const auto response = FitScrewResponse(bed.OneByOne(1), kDrawn_mm, 0.001);
  const Eigen::Matrix3d gain = LevellingGain(response, kDrawn_mm);
  const Vec3<double> before_mm(0.3, -0.5, 0.8);

  Vec3<double> after_mm = before_mm;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector2d& at_mm = kDrawn_mm[static_cast<std::size_t>(k)];
    after_mm[k] -=
        ScrewWeights<double>(bed.standing_mm, at_mm[0], at_mm[1]).dot(before_mm);
  }

  EXPECT_LT((gain * before_mm - after_mm).norm(), 1e-6);
}

TEST(StoppedHeight, IsReadFromTheReply) {
  EXPECT_DOUBLE_EQ(*StoppedHeight_mm({"Stopped at height -0.123 mm"}), -0.123);
  EXPECT_FALSE(StoppedHeight_mm({"Z probe value 530"}));
}

/// A wire that answers every line alike.
class Parrot : public Link {
 public:
  explicit Parrot(std::string answer) : answer_(std::move(answer)) {}
  Expected<std::vector<std::string>> Send(std::string_view line,
                                          std::chrono::milliseconds) override {
    said.emplace_back(line);
    return std::vector<std::string>{answer_};
  }
  std::vector<std::string> said{};

 private:
  std::string answer_;
};

TEST(TripleZPrinter, WhatIsNoHeightIsNotTakenForOne) {
  for (const char* said : {"nan mm", "inf mm", "0.12e mm", "1e30 mm", "0.1;2 mm"}) {
    Parrot wire(std::string("Stopped at height ") + said);
    TripleZPrinter printer({.link = &wire, .drawn_mm = kDrawn_mm});

    EXPECT_FALSE(printer.Probe({20, 20})) << said;
  }
}

TEST(TripleZPrinter, NamesAReplyThatItCannotParse) {
  Parrot wire("Z probe value 530");
  TripleZPrinter printer({.link = &wire, .drawn_mm = kDrawn_mm});

  const auto height_mm = printer.Probe({20, 20});

  ASSERT_FALSE(height_mm);
  EXPECT_THAT(
      height_mm.error().reply,
      HasSubstr("Could not parse probe response 'Z probe value 530' to G30 X20"));
}

TEST(TripleZPrinter, MovesScrewsSinglyAndWaits) {
  Parrot wire("ok");
  TripleZPrinter printer({.link = &wire, .drawn_mm = kDrawn_mm});

  ASSERT_TRUE(printer.MoveTripleZ(30, 40, {200, 201, 199.5}));

  EXPECT_THAT(wire.said,
              ElementsAre("G28",
                          "G1 X30 Y40",
                          "M584 Z0 U1 V2 P5",
                          "G92 U250 V250",
                          "G1 Z50 U49 V50.5",
                          "M400",
                          "M584 Z0:1:2 P3",
                          "G92 Z50"));
}

TEST(TripleZPrinter, RefusesHeightsOutsideTheTravel) {
  Parrot wire("ok");
  TripleZPrinter printer({.link = &wire, .drawn_mm = kDrawn_mm});

  const auto moved = printer.MoveTripleZ(30, 40, {0, 250.5, 1});

  ASSERT_FALSE(moved);
  EXPECT_THAT(moved.error().reply, HasSubstr("z2 = 250.5 is outside 0 .. 250 mm"));
  EXPECT_TRUE(wire.said.empty());
}

}  // namespace
}  // namespace caltwin
