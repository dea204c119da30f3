#include <array>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "calibration/estimate/expanded.h"
#include "sim/base/rng.h"

namespace caltwin {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

// JCGM 100 (GUM), table H.1: calibration of an end gauge of 50 mm, in nm.
const std::vector<Contribution> kEndGauge = {
    {.input = "calibration of the standard", .u = 25, .dof = 18},
    {.input = "repeated observations", .u = 5.8, .dof = 24},
    {.input = "random effects of the comparator", .u = 3.9, .dof = 5},
    {.input = "systematic effects of the comparator", .u = 6.7, .dof = 8},
    {.input = "difference in expansion coefficients", .u = 2.9, .dof = 50},
    {.input = "difference in temperatures", .u = 16.6, .dof = 2}};

TEST(Expanded, EndGaugeOfTheGuideHasItsUncertaintyAndFreedom) {
  // H.1.6: u = 32 nm, nu_eff = 16.7, so 16; t99(16) = 2.92, U99 = 93 nm.
  const Expanded expanded = Expand(kEndGauge, 0.99);

  EXPECT_NEAR(expanded.u, 32, 0.5);
  EXPECT_EQ(std::floor(expanded.dof), 16);
  EXPECT_NEAR(expanded.k, 2.92, 0.005);
  EXPECT_NEAR(expanded.U, 93, 1);
}

TEST(Expanded, CoverageFactorsAreThoseOfTheGuidesTable) {
  // JCGM 100, table G.2.
  struct Entry {
    double dof, t95, t99;
  };
  for (const Entry& entry : std::array<Entry, 6>{{{1, 12.71, 63.66},
                                                  {2, 4.30, 9.92},
                                                  {5, 2.57, 4.03},
                                                  {10, 2.23, 3.17},
                                                  {50, 2.01, 2.68},
                                                  {kNever, 1.960, 2.576}}}) {
    EXPECT_NEAR(CoverageFactor(entry.dof), entry.t95, 0.0051) << entry.dof;
    EXPECT_NEAR(CoverageFactor(entry.dof, 0.99), entry.t99, 0.0051) << entry.dof;
  }
  EXPECT_EQ(CoverageFactor(5.9), CoverageFactor(5));  // G.4.1: the next lower integer.
}

TEST(Expanded, FreedomOfTwoAlikeInputsAddsUp) {
  const std::vector<Contribution> alike{{.u = 2, .dof = 7}, {.u = 2, .dof = 7}};

  EXPECT_NEAR(EffectiveDof(alike), 14, 1e-12);
}

TEST(Expanded, ARectangleAloneIsHeldByNinetyFivePercentOfItsWidth) {
  // EA-4/02 S9.14: k = 1.65, U = 0.95 half widths.
  const double half = 0.005;
  const std::vector<Contribution> feeler{
      {.u = half / std::sqrt(3.0), .is_rectangular = true}};

  const Expanded expanded = Expand(feeler);

  EXPECT_NEAR(expanded.U, 0.95 * half, 1e-9);
  EXPECT_NEAR(expanded.k, 0.95 * std::sqrt(3.0), 1e-6);
}

TEST(Expanded, ARectangleUnderMuchNoiseIsNormal) {
  const std::vector<Contribution> shaken{{.u = 1, .is_rectangular = true}, {.u = 20}};

  EXPECT_NEAR(Expand(shaken).k, 1.96, 1e-3);
}

TEST(Expanded, AnInputsOwnUncertaintyLosesItsWidening) {
  const double widened = 3 * CoverageFactor(4) / CoverageFactor(kNever);

  const Contribution input = InputOf("readings", -2, {.sd = widened, .dof = 4});

  EXPECT_NEAR(input.u, 6, 1e-9);
}

TEST(Expanded, SdIsUOver196SoThatIntervalsAgree) {
  const Uncertain told = WithBudget(7, {{.input = "a", .u = 3, .dof = 4}});

  EXPECT_NEAR(1.959964 * told.sd, CoverageFactor(4) * 3, 1e-5);
  EXPECT_TRUE(told.identifiable);
}

TEST(Expanded, WhatIsNotKnownMakesNoEstimate) {
  EXPECT_FALSE(WithBudget(7, {{.u = 1}, {.u = kNever}}).identifiable);
}

TEST(Expanded, AnInputAddedLaterAddsInSquares) {
  const Uncertain plain{.value = 1, .sd = 3, .identifiable = true};

  const Uncertain wider = WithInput(plain, {.input = "steps/mm", .u = 4});

  EXPECT_NEAR(wider.sd, 5, 1e-9);
  ASSERT_EQ(wider.budget.size(), 2U);
  EXPECT_EQ(wider.budget.front().input, "readings");
}

// By counting: how often offset + sd z lies within the interval.
TEST(NotCorrected, TheWiderIntervalHoldsNinetyFivePercent) {
  constexpr int kDraws = 200'000;
  constexpr double kSd = 0.5;
  for (const double offset : {-1.0, 0.1, 0.5}) {
    const double limit =
        1.959963984540054 * std::hypot(kSd, NotCorrected(offset, kSd).u);
    Rng rng(1, 0, "offset");
    int held = 0;
    for (int i = 0; i < kDraws; ++i) {
      held += std::abs(offset + kSd * rng.Normal()) <= limit ? 1 : 0;
    }
    EXPECT_NEAR(held, 0.95 * kDraws, 5 * std::sqrt(0.95 * 0.05 * kDraws)) << offset;
  }
  EXPECT_EQ(NotCorrected(0, kSd).u, 0);
  EXPECT_EQ(NotCorrected(1, 0).u, 0);
}

}  // namespace
}  // namespace caltwin
