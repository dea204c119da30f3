#include "sim/effects/forms.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/effects/catalog.h"

namespace caltwin {
namespace {

using ::testing::Contains;
using ::testing::DoubleNear;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

// Every moment of a run of 6000 s over the whole of a gantry's travel.
Extent WholeRun() {
  Extent extent{.t_max_s = 6000, .q_max_mm = {300, 300, 120}};
  for (int i = 0; i <= 100; ++i) extent.times_s.push_back(60.0 * i);
  return extent;
}

TEST(Forms, PeriodsReachThreePercentAndHoldTheDrawnOne) {
  const auto periods_mm = Periods_mm(4, 300);

  EXPECT_THAT(periods_mm, Contains(4));
  EXPECT_NEAR(periods_mm.front(), 4 * 0.97, 4 * 0.5 / 75);
  EXPECT_NEAR(periods_mm.back(), 4 * 1.03, 4 * 0.5 / 75);
}

TEST(Forms, BetweenNeighbouringPeriodsThePhaseAtTheEndsMovesByAQuarterTurn) {
  for (const double span_mm : {3.0, 40.0, 300.0, 3000.0}) {
    const auto periods_mm = Periods_mm(4, span_mm);
    for (std::size_t i = 1; i < periods_mm.size(); ++i) {
      const double turns =
          std::abs(span_mm / 2 / periods_mm[i] - span_mm / 2 / periods_mm[i - 1]);
      EXPECT_LE(turns, 0.25 * 1.07) << span_mm;  // 1 / 0.97^2 at the short end.
    }
  }
}

TEST(Forms, OverLessThanAQuarterOfAPeriodAWaveIsALine) {
  EXPECT_THAT(Periods_mm(40, 9), IsEmpty());
  EXPECT_THAT(Periods_mm(40, 11), Not(IsEmpty()));
}

TEST(Forms, OverManyPeriodsTheGridStaysSmall) {
  EXPECT_THAT(Periods_mm(0.5, 3000), SizeIs(25));
}

TEST(Forms, LagsBeginAtNoneAndEndWithTheRun) {
  EXPECT_THAT(Lags_s({.t_max_s = 150}), ElementsAre(0, 50, 100, 200, 400));
  EXPECT_THAT(Lags_s({}), ElementsAre(0));
  EXPECT_EQ(Lags_s({.t_max_s = 1e6}).back(), 6400);
}

TEST(Forms, TimeConstantsSpanFromAFractionToSeveralRuns) {
  const auto tau_s = TimeConstants_s({.t_min_s = 1000, .t_max_s = 3000});

  EXPECT_NEAR(tau_s.front(), 100, 1e-9);
  EXPECT_NEAR(tau_s.back(), 6000, 1e-9);
  EXPECT_THAT(TimeConstants_s({.t_min_s = 5, .t_max_s = 5}), IsEmpty());
}

TEST(Forms, JumpsLieBetweenEveryTwoNeighbouringRows) {
  EXPECT_THAT(JumpTimes_s({.times_s = {0, 10, 30}}), ElementsAre(5, 20));
  EXPECT_THAT(JumpTimes_s({.times_s = {7}}), IsEmpty());
}

TEST(Forms, OfManyRowsTwoHundredJumpsAreChosenEvenly) {
  Extent extent;
  for (int i = 0; i <= 2000; ++i) extent.times_s.push_back(i);

  const auto jumps_s = JumpTimes_s(extent);

  ASSERT_THAT(jumps_s, SizeIs(200));
  for (std::size_t i = 1; i < jumps_s.size(); ++i) {
    EXPECT_NEAR(jumps_s[i] - jumps_s[i - 1], 10, 1e-9);
  }
  EXPECT_NEAR(jumps_s.front(), 2000 - jumps_s.back(), 1 + 1e-9);
}

TEST(Forms, AScrewHasALeadAndABeltAPulley) {
  Machine machine{.name = "test"};
  machine.axes[1].is_belt = true;
  machine.axes[1].lead_mm = 40;
  const auto screw = CyclicLead::kDeclaration.sight->forms;
  const auto pulley = PulleyEccentric::kDeclaration.sight->forms;

  EXPECT_THAT(screw(machine, "x", WholeRun()), Contains(ElementsAre(4)));
  EXPECT_THAT(screw(machine, "y", WholeRun()), IsEmpty());
  EXPECT_THAT(pulley(machine, "x", WholeRun()), IsEmpty());
  EXPECT_THAT(pulley(machine, "y", WholeRun()), Contains(ElementsAre(40)));
}

TEST(Forms, WearIsSoughtOnlyWhereRowsReachAlongTheAxis) {
  Extent at_one_place = WholeRun();
  at_one_place.q_min_mm[0] = 299;
  const auto worn = BacklashWorn::kDeclaration.sight->forms;

  EXPECT_THAT(worn({}, "x", WholeRun()), SizeIs(9 * 5));
  EXPECT_THAT(worn({}, "x", at_one_place), IsEmpty());
}

// The words that files and JSON have for what a residual may depend on.
constexpr std::array<std::string_view, 12> kCovariates = {"x",
                                                          "y",
                                                          "z",
                                                          "t",
                                                          "temp",
                                                          "dir_x",
                                                          "dir_y",
                                                          "dir_z",
                                                          "since_rev",
                                                          "feed",
                                                          "load",
                                                          "theta"};
constexpr std::array<std::string_view, 5> kChannels = {"x", "y", "z", "probe", "bed"};

// Whatever the effect: as many values as it has form parameters, within their bounds.
void ExpectGridWithinBounds(const Effect& effect, std::string_view axis) {
  std::vector<Parameter> forms;
  std::ranges::copy_if(effect.parameters, std::back_inserter(forms), [](const auto& p) {
    return p.role == Role::kForm;
  });
  ASSERT_EQ(effect.sight->forms != nullptr, !forms.empty()) << effect.name;
  if (forms.empty()) return;
  for (const auto& entry : effect.sight->forms(Machine{}, axis, WholeRun())) {
    ASSERT_THAT(entry, SizeIs(forms.size())) << effect.name;
    for (std::size_t i = 0; i < forms.size(); ++i) {
      EXPECT_GE(entry[i], forms[i].min) << effect.name << ' ' << forms[i].name;
      EXPECT_LE(entry[i], forms[i].max) << effect.name << ' ' << forms[i].name;
    }
  }
}

TEST(Sight, OfEveryEffectSpeaksTheFilesWordsAndKeepsToItsBounds) {
  for (const Effect* effect : AllEffects()) {
    if (!effect->sight) continue;
    for (const std::string_view axis : effect->axes) {
      const Shown shown = effect->sight->shown(axis);
      EXPECT_THAT(kChannels, Contains(shown.channel)) << effect->name;
      for (const std::string& covariate : shown.covariates) {
        EXPECT_THAT(kCovariates, Contains(covariate)) << effect->name;
      }
      ExpectGridWithinBounds(*effect, axis);
    }
  }
}

TEST(Sight, WhatCannotBeFoundHasNone) {
  EXPECT_FALSE(RandomWalk::kDeclaration.sight);
}

}  // namespace
}  // namespace caltwin
