// Jumps against what only looks like them, and shapes that leave too much.
#include "calibration/diagnosis/own_shape.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "calibration/diagnosis/gates.h"
#include "calibration/diagnosis/search.h"
#include "sim/base/rng.h"
#include "sim/effects/catalog.h"
#include "sim/machine/kinds/kinds.h"

namespace caltwin {
namespace {

constexpr double kSigma_mm = 1e-3;
constexpr double kStep_s = 30;
const double kCertain_nats = std::log(20.0);
constexpr Eigen::Index kRows = 90;
constexpr Eigen::Index kMiddle = 45;

Machine Plain() {
  Machine machine{.name = "test"};
  machine.settings.steps_per_mm = {800, 800, 800};
  return machine;
}

// One place along x, read again and again, with noise and what `moved_um` says.
template <typename Moved>
Observed Datum(const Moved& moved_um, std::uint64_t draw = 0) {
  Rng rng(11, draw, "own_shape_test");
  RowTable table;
  for (Eigen::Index i = 0; i < kRows; ++i) {
    Row row{.row = i + 1, .campaign = "datum"};
    row.t_s = kStep_s * static_cast<double>(i);
    row.cmd_mm = {50, 0, 0};
    row.dir = {1, 0, 0};
    row.n = {1, 0, 0};
    row.value_mm = 1e-3 * moved_um(static_cast<double>(i)) + kSigma_mm * rng.Normal();
    table.rows.push_back(row);
  }
  return {table, {}, Plain(), {}};
}

Circumstances Offset() {
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(kRows);
  return {
      .sigma_mm = ones * kSigma_mm,
      .nuisances = {{.name = "offset", .unit = "mm", .column_mm = ones, .prior_sd = 1}},
      .left_out = std::vector<bool>(static_cast<std::size_t>(kRows), false)};
}

Candidate LostSteps(const Observed& observed) {
  const std::vector<Candidate> all = AllCandidates(observed);
  return *std::ranges::find(all, "missed_steps.x", &Candidate::Name);
}

const Variant& JumpBefore(const Candidate& jump, Eigen::Index row) {
  return *std::ranges::find_if(jump.variants, [&](const Variant& variant) {
    return variant.forms[0] > kStep_s * (static_cast<double>(row) - 1);
  });
}

TEST(OwnShape, AJumpIsNotGradual) {
  const Observed observed = Datum([](double i) { return i < kMiddle ? 0.0 : 6.0; });
  EXPECT_LT(GradualOdds(observed, Offset(), LostSteps(observed)), 0);
}

TEST(OwnShape, ACreepIsGradualThoughAJumpFitsIt) {
  const Observed observed =
      Datum([](double i) { return 5 * (1 - std::exp(-std::max(i - 40, 0.0) / 4)); });
  const Candidate jump = LostSteps(observed);
  EXPECT_GT(Weigh(observed, {jump}, Offset()).ranked[0].log_odds, 0);
  EXPECT_GT(GradualOdds(observed, Offset(), jump), kCertain_nats);
}

// Over `length` rows about the middle.
double RampOdds(double height_um, double length, std::uint64_t draw) {
  const Observed observed = Datum(
      [&](double i) {
        return height_um * std::clamp((i - kMiddle) / length + 0.5, 0.0, 1.0);
      },
      draw);
  return GradualOdds(observed, Offset(), LostSteps(observed));
}

// A low one may be doubtful, and is never taken for a jump.
TEST(OwnShape, ARampIsGradualWhateverTheNoise) {
  constexpr int kDraws = 20;
  int certain = 0;
  for (std::uint64_t draw = 0; draw < kDraws; ++draw) {
    EXPECT_GT(RampOdds(20, 60, draw), kCertain_nats) << draw;
    const double low_nats = RampOdds(8, 30, draw);
    EXPECT_GT(low_nats, 0) << draw;
    certain += low_nats > kCertain_nats ? 1 : 0;
  }
  EXPECT_GE(certain, kDraws / 2);
}

// One row stands before it; what goes on behind it, freedom of form takes up.
TEST(OwnShape, AJumpBesideOneRowIsNotByMany) {
  const Observed observed =
      Datum([](double i) { return i < 1 ? 27 : 8 * std::sin(0.1 * i); });
  Candidate jump = LostSteps(observed);
  jump.variants = {JumpBefore(jump, 1)};
  const Weighed weighed = Weigh(observed, {jump}, Offset()).ranked[0];

  ASSERT_GT(weighed.log_odds, 0);
  EXPECT_FALSE(SupportOf(observed, Offset(), 0, jump, weighed).is_by_many);
}

TEST(OwnShape, AJumpAmongManyRowsIsByMany) {
  const Observed observed = Datum([](double i) { return i < kMiddle ? 0.0 : 27.0; });
  Candidate jump = LostSteps(observed);
  jump.variants = {JumpBefore(jump, kMiddle)};
  const Weighed weighed = Weigh(observed, {jump}, Offset()).ranked[0];

  EXPECT_TRUE(SupportOf(observed, Offset(), 0, jump, weighed).is_by_many);
}

TEST(OwnShape, OnlyJumpsCanBeGradual) {
  const Observed observed = Datum([](double i) { return i / 10; });
  const Candidate screw{.cause = "thermal_screw"};
  EXPECT_LT(GradualOdds(observed, Offset(), screw), -1e300);
}

TEST(OwnShape, AShapeMayNotLeaveHalfOfItsHeight) {
  const auto wave = [](double i) {
    return 8 * std::sin(0.3 * i);
  };
  Eigen::MatrixXd shape(kRows, 1);
  for (Eigen::Index i = 0; i < kRows; ++i) {
    shape(i, 0) = wave(static_cast<double>(i));
  }
  const auto leaves_too_much = [&](double more_um) {
    const Observed observed =
        Datum([&](double i) { return wave(i) + more_um * std::sin(0.9 * i); });
    return LeavesTooMuch(FitPlain(
        observed, Offset(), /*wander_mm2_per_s=*/0, shape, Eigen::VectorXd::Ones(1)));
  };
  EXPECT_FALSE(leaves_too_much(0));
  EXPECT_FALSE(leaves_too_much(2));
  EXPECT_TRUE(leaves_too_much(6));
}

// A wave of 8 um on a machine that wanders by 30 um/sqrt(h): the wander, seven sigma in
// all, is no fault of the wave's shape once it counts as noise.
TEST(OwnShape, AWanderIsNoLackOfFit) {
  constexpr double kWander_mm2_per_s = 0.03 * 0.03 / 3600;
  const auto wave = [](double i) {
    return 8 * std::sin(0.9 * i);
  };
  Rng rng(5, 0, "own_shape_test.wander");
  double at_um = 0;
  const Observed observed = Datum([&](double i) {
    at_um += 1e3 * std::sqrt(kWander_mm2_per_s * kStep_s) * rng.Normal();
    return wave(i) + at_um;
  });
  Eigen::MatrixXd shape(kRows, 1);
  for (Eigen::Index i = 0; i < kRows; ++i) {
    shape(i, 0) = 1e-3 * wave(static_cast<double>(i));
  }
  const auto fit = [&](double wander_mm2_per_s) {
    return FitPlain(
        observed, Offset(), wander_mm2_per_s, shape, Eigen::VectorXd::Ones(1));
  };
  EXPECT_TRUE(LeavesTooMuch(fit(0), Form::kExact));
  EXPECT_FALSE(LeavesTooMuch(fit(kWander_mm2_per_s), Form::kExact));
}

// Whatever a search begins with, it ends with what the rows show.
TEST(OwnShape, ASearchThatBeginsElsewhereFindsTheSame) {
  const Observed observed = Datum([](double i) { return i < kMiddle ? 0.0 : 6.0; });
  const std::vector<Candidate> candidates = AllCandidates(observed);
  const auto found_from = [&](const std::vector<std::string>& start) {
    std::vector<std::string> names;
    for (const Found& found : Search(observed, candidates, {.start = start}).found) {
      names.push_back(candidates[found.candidate].Name());
    }
    return names;
  };
  const std::vector<std::string> jump = {"missed_steps.x"};

  EXPECT_EQ(found_from({}), jump);
  EXPECT_EQ(found_from(jump), jump);
  EXPECT_EQ(found_from({"unknown.x{t}"}), jump);
  EXPECT_EQ(found_from({"frame_growth", "no such cause"}), jump);
}

TEST(OwnShape, NoiseIsNoLackOfFit) {
  EXPECT_FALSE(LeavesTooMuch({.explained = 60, .left = 35, .doubt = 20}));
  EXPECT_TRUE(LeavesTooMuch({.explained = 60, .left = 45, .doubt = 20}));
  EXPECT_TRUE(LeavesTooMuch({.explained = 600, .left = 240, .doubt = 20}));
}

TEST(OwnShape, WhatIsKnownByItsSizeHasNoShapeToShow) {
  EXPECT_FALSE(LeavesTooMuch({.explained = 1, .left = 200, .doubt = 20}));
}

TEST(OwnShape, GeometryIsExactAndPlatesOfPrintersAreClose) {
  const Candidate rod{.effect = EffectIndex<RodMismatch>(), .axis = "a1"};
  const Candidate bowl{.effect = EffectIndex<BedBowl>(), .shown = {"bed", {"x", "y"}}};
  const Machine delta{.kind = DeltaKind()};

  EXPECT_EQ(FormOf(rod, delta), Form::kExact);
  EXPECT_EQ(FormOf(bowl, delta), Form::kClose);
  EXPECT_EQ(FormOf(bowl, Plain()), Form::kLike);
  EXPECT_EQ(FormOf({.effect = EffectIndex<FrameTemperature>()}, delta), Form::kLike);
}

TEST(OwnShape, WhatIsExactLeavesAFifthOfItsHeightAtMost) {
  const PlainFit some{.explained = 600, .left = 60, .doubt = 20};
  EXPECT_TRUE(LeavesTooMuch(some, Form::kExact));
  EXPECT_TRUE(LeavesTooMuch(some, Form::kClose));
  EXPECT_FALSE(LeavesTooMuch(some, Form::kLike));
  EXPECT_FALSE(
      LeavesTooMuch({.explained = 600, .left = 40, .doubt = 20}, Form::kExact));
}

// Of what hardly shows the rows bear the proof: what noise may hide counts against it.
TEST(OwnShape, WhatIsProvenLeavesLessThanAFifthOfItsHeightWhateverNoiseHides) {
  EXPECT_TRUE(IsProven({.explained = 1400, .left = 35, .doubt = 14}, 1));
  EXPECT_FALSE(IsProven({.explained = 1400, .left = 45, .doubt = 14}, 1));
  EXPECT_FALSE(IsProven({.explained = 1400, .left = 45, .doubt = 14}, 3));
  EXPECT_FALSE(IsProven({.explained = 300, .left = 0, .doubt = 14}, 1));
  EXPECT_FALSE(IsProven({}, 1));
  // Half of what its form may differ by: a quarter may be left.
  EXPECT_TRUE(IsProven({.explained = 1400, .left = 0, .doubt = 13}, 0.5));
  EXPECT_FALSE(IsProven({.explained = 1400, .left = 2, .doubt = 13}, 0.5));
}

TEST(OwnShape, GeometryIsNotKnownByItsSizeAlone) {
  const PlainFit nothing{.explained = 1, .left = 0, .doubt = 20};
  EXPECT_TRUE(LeavesTooMuch(nothing, Form::kExact));
  EXPECT_FALSE(LeavesTooMuch(nothing, Form::kClose));
}

// Beside an offset a half of ones shows by its scatter about the mean, one half of its
// height, of a root mean square of 1 / sqrt(2).
TEST(OwnShape, WhatTheOffsetTakesUpDoesNotShow) {
  const Observed observed = Datum([](double) { return 0.0; });
  Eigen::VectorXd half = Eigen::VectorXd::Zero(kRows);
  half.head(kRows / 2).setOnes();
  constexpr double kNeglected = 1e-5;  // The offset's prior: (sigma / sd)^2.

  EXPECT_NEAR(ShownPart(observed, Offset(), half), std::sqrt(0.5), kNeglected);
  EXPECT_NEAR(ShownPart(observed, Offset(), Eigen::VectorXd::Ones(kRows)), 0, 1e-3);
  EXPECT_EQ(ShownPart(observed, Offset(), Eigen::VectorXd::Zero(kRows)), 0);
}

TEST(OwnShape, RowsFullOfOutliersShowNoJump) {
  const Observed observed = Datum([](double) { return 0.0; });
  const Candidate jump = LostSteps(observed);
  std::vector<bool> out = Offset().left_out;
  for (const std::size_t i : {28, 44, 47, 50}) out[i] = true;
  EXPECT_FALSE(IsAmongOutliers(observed, out, jump, JumpBefore(jump, kMiddle)));
  out[55] = true;
  EXPECT_TRUE(IsAmongOutliers(observed, out, jump, JumpBefore(jump, kMiddle)));
  EXPECT_FALSE(IsAmongOutliers(observed, out, jump, JumpBefore(jump, 80)));
}

// A wave that rows within `span_rad` of its phase see.
Candidate Wave(double span_rad) {
  Variant variant{.columns_mm = Eigen::MatrixXd(kRows, 1), .usual_mm = 0.01};
  for (Eigen::Index i = 0; i < kRows; ++i) {
    variant.columns_mm(i, 0) = std::cos(span_rad * static_cast<double>(i) / kRows);
  }
  return {.effect = 0,
          .cause = "wave",
          .shown = {.channel = "z", .covariates = {"z"}},
          .variants = {variant}};
}

Weighed Sized(double size_mm) {
  return {.sizes_mm = Eigen::VectorXd::Constant(1, size_mm)};
}

TEST(IsBorrowed, OfAHugeWaveOnlyTheCurveShows) {
  const Observed observed = Datum([](double) { return 0.0; });

  EXPECT_TRUE(IsBorrowed(observed, Offset(), Wave(0.1), Sized(0.8)));
  EXPECT_FALSE(IsBorrowed(observed, Offset(), Wave(0.1), Sized(0.05)));  // Usual.
  Candidate tip = Wave(0.1);
  tip.shown.covariates = {"theta"};
  EXPECT_FALSE(IsBorrowed(observed, Offset(), tip, Sized(0.8)));
  EXPECT_FALSE(IsBorrowed(observed, Offset(), Wave(6), Sized(0.8)));  // It shows.
}

}  // namespace
}  // namespace caltwin
