#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/estimate/joint.h"
#include "tests/calibration/estimate_joint_rows.h"

namespace caltwin {
namespace {

using joint_test::Block;
using joint_test::Gantry;
using joint_test::Gap;
using joint_test::Hidden;
using joint_test::Latency;
using joint_test::Pretravel;
using joint_test::Problem;
using joint_test::Steps;
using joint_test::Tip;
using joint_test::TouchX;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

const Hidden kHidden;

std::vector<FreeParameter> Everything() {
  return {Steps(), Gap(), Pretravel(), Tip(kHidden.radius_mm - 1.0, 1e-5), Latency()};
}

TEST(JointEstimate, RecoversEverythingFromNoiselessTouchesAndReleases) {
  Rng rng(1, 0, "joint");

  const JointFit fit =
      FitJoint(Problem(Block(kHidden, 2, true, &rng, 0), Everything()));

  ASSERT_TRUE(fit.converged) << fit.message;
  // What beliefs of 0.05 mm and 1 % leave against readings of 1 um: their square ratio.
  constexpr double kBelief_mm = 0.05 * (0.002 / 0.05) * (0.002 / 0.05);
  EXPECT_NEAR(fit.Find("steps_per_mm.x")->value, 795, 2e-3);
  EXPECT_NEAR(fit.Find("backlash.x")->value, 0.06, kBelief_mm);
  EXPECT_NEAR(fit.Find("probe_pretravel.x")->value, 0.03, kBelief_mm);
  EXPECT_NEAR(fit.Find("trigger_latency")->value, 0.3, 0.01);
  // Placed 0.2 mm off, and seen in true millimetres.
  EXPECT_NEAR(fit.Find("placement.short.x")->value, 0.2, 1e-3);
  for (const JointEstimate& estimate : fit.estimates) {
    EXPECT_TRUE(estimate.identifiable) << estimate.name;
  }
  EXPECT_THAT(fit.observability.blind, IsEmpty());
}

TEST(JointEstimate, SpansAloneTellOnlyTheSumAndNoPriorHidesIt) {
  Rng rng(2, 0, "joint");

  const JointFit fit =
      FitJoint(Problem(Block(kHidden, 10, false, &rng), {Steps(), Gap(), Pretravel()}));

  EXPECT_TRUE(fit.Find("steps_per_mm.x")->identifiable);
  EXPECT_FALSE(fit.Find("backlash.x")->identifiable);
  EXPECT_FALSE(fit.Find("probe_pretravel.x")->identifiable);
  ASSERT_EQ(fit.observability.blind.size(), 1u);
  EXPECT_EQ(fit.observability.blind[0].statement,
            "probe_pretravel.x + backlash.x / 2 only");
  EXPECT_THAT(fit.observability.advice, Contains(HasSubstr("release")));
  // The sum itself is known to the touches' noise; what was not asked for, the tip's
  // error and the latency at 1 mm/s, stays in it.
  const double sum_mm =
      fit.Find("probe_pretravel.x")->value + fit.Find("backlash.x")->value / 2;
  const double expected_mm = kHidden.pretravel_mm + kHidden.backlash_mm / 2 -
                             (kHidden.radius_mm - 1.0) + 1.0 * kHidden.latency_s;
  EXPECT_NEAR(sum_mm, expected_mm, 4 * joint_test::kSigma_mm);
}

TEST(JointEstimate, AnUnreadParameterKeepsItsPrior) {
  Rng rng(3, 0, "joint");
  FreeParameter y{.effect = EffectIndex<Backlash>(), .axis = "y"};

  const JointFit fit =
      FitJoint(Problem(Block(kHidden, 2, true, &rng), {Steps(), Gap(), y}));

  const JointEstimate& unread = *fit.Find("backlash.y");
  const Given belief = DeclaredPrior(Gantry(), y);
  EXPECT_FALSE(unread.identifiable);
  EXPECT_NEAR(unread.sd, belief.sd, 1e-6 * belief.sd);
  EXPECT_NEAR(unread.value, belief.value, 1e-6 * belief.sd);
}

TEST(JointEstimate, ZWithoutALedgeIsAbsorbedByTheDatum) {
  // Touches of a top face and nothing else.
  RowTable table;
  Row row{.kind = RowKind::kTouch, .setup = "block"};
  row.cmd_mm = {150, 150, 25.4};
  row.n = {0, 0, 1};
  row.dir = {0, 0, -1};
  row.feed_mm_s = 1;
  row.value_mm = -0.02;
  table.rows = {row, row, row};
  const FreeParameter z{.effect = EffectIndex<ProbePretravel>(), .axis = "z"};

  const JointProblem top = Problem(table, {z});
  EXPECT_FALSE(FitJoint(top).Find("probe_pretravel.z")->identifiable);
  const ObservabilityReport before = ObserveJoint(top);
  ASSERT_EQ(before.blind.size(), 1u);
  EXPECT_EQ(before.blind[0].statement, "probe_pretravel.z - placement.block.z only");

  // The underside of a lip of 5 mm on the same block, with the disc stylus.
  row.cmd_mm[2] = 20.4;
  row.n[2] = -1;
  row.dir[2] = 1;
  table.rows.push_back(row);
  const JointFit fit = FitJoint(Problem(table, {z}));
  EXPECT_TRUE(fit.Find("probe_pretravel.z")->identifiable);
  EXPECT_NEAR(fit.Find("probe_pretravel.z")->value, 0.02, 1e-4);
}

TEST(JointEstimate, VerdictBeforeMeasuringIsTheVerdictAfter) {
  Rng rng(4, 0, "joint");
  JointProblem plan =
      Problem(Block(kHidden, 2, false, &rng), {Steps(), Gap(), Pretravel()});
  const JointFit after = FitJoint(plan);
  for (Observation& observation : plan.observations) observation.value_mm = 0;

  const ObservabilityReport before = ObserveJoint(plan);

  ASSERT_EQ(before.blind.size(), after.observability.blind.size());
  EXPECT_EQ(before.blind[0].statement, after.observability.blind[0].statement);
}

TEST(JointEstimate, OneWildRowHardlyMovesHuber) {
  Rng rng(5, 0, "joint");
  JointProblem problem = Problem(Block(kHidden, 10, true, &rng), Everything());
  const double honest_mm = FitJoint(problem).Find("backlash.x")->value;
  problem.observations[20].value_mm += 1;  // a release at the lower feed

  const double squares_mm = FitJoint(problem).Find("backlash.x")->value;
  problem.loss = Loss::kHuber;
  const JointFit huber = FitJoint(problem);

  const JointEstimate& backlash = *huber.Find("backlash.x");
  EXPECT_GT(std::abs(squares_mm - honest_mm), 10 * backlash.sd);
  EXPECT_LT(std::abs(backlash.value - honest_mm), 2 * backlash.sd);
}

TEST(JointEstimate, HuberCostsATwentiethOfTheVariance) {
  Rng rng(6, 0, "joint");
  JointProblem problem = Problem(Block(kHidden, 10, true, &rng), Everything());

  const double squares_sd = FitJoint(problem).Find("steps_per_mm.x")->sd;
  problem.loss = Loss::kHuber;
  const double huber_sd = FitJoint(problem).Find("steps_per_mm.x")->sd;

  EXPECT_NEAR(huber_sd / squares_sd, 1 / std::sqrt(0.95), 1e-3);
}

TEST(JointEstimate, RowsOfEachSettingsCountWithTheirOwn) {
  // The same machine touched under 800 and under 795 steps/mm: each has its own scale,
  // one truth fits both.
  Rng rng(7, 0, "joint");
  RowTable table = Block(kHidden, 2, true, &rng, 0);
  for (Row& row : table.rows) row.settings = "before";
  for (const double size_mm : {25.4, 76.2}) {
    for (const int normal : {-1, +1}) {
      Row row = TouchX(kHidden,
                       {.at_mm = 150 + normal * size_mm / 2,
                        .normal = normal,
                        .setup = size_mm < 50 ? "short" : "long"},
                       0,
                       795);
      row.settings = "after";
      table.rows.push_back(row);
    }
  }
  Settings before = Gantry().settings;
  Settings after = before;
  after.steps_per_mm[0] = 795;
  JointProblem problem = Problem({}, Everything());
  problem.observations =
      ObservationsOf(table,
                     problem.machine,
                     {.settings = {{"before", before}, {"after", after}},
                      .default_sigma_mm = joint_test::kSigma_mm});

  const JointFit fit = FitJoint(problem);

  EXPECT_NEAR(fit.Find("steps_per_mm.x")->value, 795, 2e-3);
  EXPECT_LT(fit.rms_mm, 1e-5);
  EXPECT_NE(fit.Find("placement.long@after.x"), nullptr);
}

TEST(JointEstimate, TiltOfTheTableComesFromItsHeights) {
  RowTable table;
  const Machine machine = Gantry();
  for (const double x : {50.0, 150.0, 250.0}) {
    for (const double y : {60.0, 240.0}) {
      Row row{.kind = RowKind::kTouch, .setup = "bed", .feature = "bed.top"};
      row.cmd_mm = {x, y, 0};
      row.n = {0, 0, 1};
      row.dir = {0, 0, -1};
      row.value_mm = 0.002 * (x - 150) - 0.001 * (y - 150) + 0.3;
      table.rows.push_back(row);
    }
  }
  const int tilt = EffectIndex<BedTilt>();

  const JointFit fit = FitJoint(Problem(
      table, {{.effect = tilt, .parameter = 0}, {.effect = tilt, .parameter = 1}}));

  // Beliefs of 2 mrad against touches of 1 um at 100 mm: below 1e-4 of the value.
  EXPECT_NEAR(fit.Find("bed_tilt.slope_x_mrad")->value, 2, 2e-4);
  EXPECT_NEAR(fit.Find("bed_tilt.slope_y_mrad")->value, -1, 2e-4);
  EXPECT_TRUE(fit.Find("bed_tilt.slope_x_mrad")->identifiable);
}

TEST(JointEstimate, CorrelationOfASumIsMinusOne) {
  Rng rng(8, 0, "joint");

  const JointFit fit =
      FitJoint(Problem(Block(kHidden, 10, false, &rng), {Steps(), Gap(), Pretravel()}));

  EXPECT_LT(fit.correlation(1, 2), -0.99);
  EXPECT_NEAR(fit.correlation(1, 1), 1, 1e-12);
}

TEST(JointEstimate, ASensibleSigmaGivesChi2NearOne) {
  Rng rng(9, 0, "joint");

  const JointFit fit = FitJoint(Problem(Block(kHidden, 20, true, &rng), Everything()));

  EXPECT_NEAR(fit.chi2_per_dof, 1, 4 * std::sqrt(2 / fit.dof));
}

TEST(JointEstimate, NothingToEstimateSaysSo) {
  EXPECT_EQ(FitJoint({.machine = Gantry()}).message, "nothing to estimate");
}

TEST(JointEstimate, TheEstimatedMachinePredictsTheReadings) {
  Rng rng(12, 0, "joint");
  const JointProblem problem = Problem(Block(kHidden, 2, true, &rng, 0), Everything());
  const JointFit fit = FitJoint(problem);

  const std::vector<Injected> built = EstimatedEffects(problem, fit);

  ASSERT_EQ(built.size(), problem.free.size());
  EXPECT_EQ(built[0].effect, EffectIndex<StepsPerMm>());
  EXPECT_DOUBLE_EQ(built[0].values[0], fit.Find("steps_per_mm.x")->value);
}

TEST(HoldOut, AModelThatLacksACauseIsWorseOnRowsItHasNotSeen) {
  Rng rng(10, 0, "joint");
  const RowTable table = Block(kHidden, 3, true, &rng);
  JointProblem full = Problem(table, Everything());
  JointProblem without_steps = Problem(
      table, {Gap(), Pretravel(), Tip(kHidden.radius_mm - 1.0, 1e-5), Latency()});

  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    full.observations[i].group = std::to_string(i % 3);  // the repeats
    without_steps.observations[i].group = full.observations[i].group;
  }

  const HoldOutError good = HoldOut(full);
  const HoldOutError bad = HoldOut(without_steps);

  EXPECT_EQ(good.groups, 3);
  EXPECT_EQ(good.predicted, static_cast<int>(table.rows.size()));
  // Held out, an error of the fit comes on top of the noise.
  EXPECT_GT(good.held_out_rms_mm, good.in_sample_rms_mm);
  EXPECT_LT(good.held_out_rms_mm, 2 * joint_test::kSigma_mm);
  EXPECT_GT(bad.held_out_rms_mm, 10 * good.held_out_rms_mm);
}

TEST(HoldOut, WhatNoOtherGroupPlacesIsNotPredicted) {
  Rng rng(11, 0, "joint");
  JointProblem problem = Problem(Block(kHidden, 1, true, &rng), Everything());
  for (Observation& observation : problem.observations) {
    observation.group = observation.nuisances.contains("placement.short.x") ? "s" : "l";
  }

  EXPECT_EQ(HoldOut(problem).predicted, 0);
}

TEST(RowToAt, ATouchIsTakenWhereTheMachineStoodAtTheTrigger) {
  Row row = TouchX(kHidden, {.at_mm = 100, .normal = -1, .feed_mm_s = 5}, 0);

  const At at = RowToAt(row, Gantry(), {});

  // q = nominal + (value + R_cfg) n.
  EXPECT_NEAR(at.q_mm.x(), 100 - (row.value_mm + 1), 1e-12);
  EXPECT_DOUBLE_EQ(at.dir.x(), 1);
  EXPECT_DOUBLE_EQ(at.feed_mm_s, 5);
  EXPECT_TRUE(at.on_table);
}

TEST(RowToAt, AReleaseMovesAwayFromTheSurface) {
  const Row row =
      TouchX(kHidden, {.at_mm = 100, .normal = -1, .feed_mm_s = 5, .release = true}, 0);

  EXPECT_TRUE(IsRelease(row));
  EXPECT_DOUBLE_EQ(RowToAt(row, Gantry(), {}).feed_mm_s, -5);
}

TEST(RowToAt, ARowWithoutADirectionIsAFaultOfTheFile) {
  Row row{.row = 7, .kind = RowKind::kTouch, .place = {.file = "a.csv", .line = 8}};

  try {
    (void)RowToAt(row, Gantry(), {});
    FAIL() << "accepted";
  } catch (const InputError& error) {
    ASSERT_EQ(error.faults().size(), 1u);
    EXPECT_EQ(error.faults()[0],
              "a.csv:8: row 7 does not say along which unit vector its value is "
              "measured: fill in nx, ny and nz");
  }
}

}  // namespace
}  // namespace caltwin
