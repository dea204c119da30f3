// The signs that docs/signs.md states, one named test each.
#include <string>

#include <gtest/gtest.h>

#include "sim/effects/predict.h"

namespace caltwin {
namespace {

constexpr double kExact = 1e-12;

Machine Gantry() {
  Machine machine{.name = "test"};
  machine.axes[2].max_mm = 120;
  machine.axes[2].home = HomeEnd::kMax;
  machine.axes[2].counterbalance_n = machine.axes[2].moving_mass_kg * kGravity_m_s2;
  return machine;
}

std::vector<Injected> With(const char* effect,
                           const char* axis,
                           std::vector<double> values) {
  return {{.effect = *FindEffect(effect), .axis = axis, .values = std::move(values)}};
}

// A position reading along an axis, at a pose.
double Position_mm(const std::vector<Injected>& effects,
                   const Vec3<double>& q_mm,
                   const Vec3<double>& n,
                   const Vec3<double>& dir = {1, 1, 1}) {
  const At at{.kind = RowKind::kPosition,
              .q_mm = q_mm,
              .dir = dir,
              .n = n,
              .steps_per_mm = {800, 800, 800}};
  return Predict_mm<double>(Gantry(), at, effects);
}

// A touch of a face with outward normal n, approached straight, on the table or not.
double Touch_mm(const std::vector<Injected>& effects,
                const Vec3<double>& q_mm,
                const Vec3<double>& n,
                bool on_table = false) {
  const At at{.q_mm = q_mm,
              .dir = -n,
              .n = n,
              .steps_per_mm = {800, 800, 800},
              .tip_radius_cfg_mm = 1,
              .feed_mm_s = 2,
              .on_table = on_table};
  return Predict_mm<double>(Gantry(), at, effects);
}

const Vec3<double> kX(1, 0, 0);
const Vec3<double> kY(0, 1, 0);
const Vec3<double> kZ(0, 0, 1);

TEST(Signs, AnAxisThatMovesOnePercentTooFarReadsPositiveOnAGaugeAndNegativeOnATouch) {
  const auto one_percent = With("steps_per_mm", "x", {800 / 1.01});

  EXPECT_NEAR(Position_mm(one_percent, {100, 0, 0}, kX), +1.0, kExact);
  const double neutral_mm = Touch_mm({}, {100, 0, 0}, kX);
  EXPECT_NEAR(Touch_mm(one_percent, {100, 0, 0}, kX) - neutral_mm, -1.0, kExact);
  EXPECT_NEAR(Touch_mm(one_percent, {100, 0, 0}, -kX) - neutral_mm, +1.0, kExact);
}

TEST(Signs, AWrongSettingOnAMachineBuiltAsDrawnMovesTooFarToo) {
  const At at{.kind = RowKind::kPosition,
              .q_mm = {100, 0, 0},
              .n = kX,
              .steps_per_mm = {808, 800, 800}};

  EXPECT_NEAR(Predict_mm<double>(Gantry(), at, {}), +1.0, kExact);
}

TEST(Signs, TheScaleErrorIsZeroAtTheHomeEnd) {
  const auto one_percent = With("steps_per_mm", "z", {800 / 1.01});

  EXPECT_NEAR(Position_mm(one_percent, {0, 0, 120}, kZ), 0, kExact);
  EXPECT_NEAR(Position_mm(one_percent, {0, 0, 20}, kZ), -1.0, kExact);
}

TEST(Signs, BacklashLagsByHalfMovingPlusAndLeadsByHalfMovingMinus) {
  const auto gap = With("backlash", "x", {0.1});

  EXPECT_NEAR(Position_mm(gap, {100, 0, 0}, kX, {+1, 0, 0}), -0.05, kExact);
  EXPECT_NEAR(Position_mm(gap, {100, 0, 0}, kX, {-1, 0, 0}), +0.05, kExact);
}

TEST(Signs, BacklashTouchedInTheSenseTheMachineMovesReadsMinusHalf) {
  const auto gap = With("backlash", "x", {0.1});

  for (const Vec3<double>& n : {kX, Vec3<double>(-kX)}) {
    EXPECT_NEAR(
        Touch_mm(gap, {100, 0, 0}, n) - Touch_mm({}, {100, 0, 0}, n), -0.05, kExact);
  }
}

TEST(Signs, CompensationIsSubtractedFromTheGap) {
  At at{.kind = RowKind::kPosition,
        .dir = {1, 0, 0},
        .n = kX,
        .steps_per_mm = {800, 800, 800}};
  at.compensation_mm = {0.08, 0, 0};

  EXPECT_NEAR(
      Predict_mm<double>(Gantry(), at, With("backlash", "x", {0.1})), -0.01, kExact);
}

TEST(Signs, PretravelReadsMinusItselfOnEveryFace) {
  const auto pretravel = With("probe_pretravel", "x", {0.03});

  EXPECT_NEAR(Touch_mm(pretravel, {100, 0, 0}, kX), -0.03, kExact);
  EXPECT_NEAR(Touch_mm(pretravel, {100, 0, 0}, -kX), -0.03, kExact);
}

TEST(Signs, PretravelPlusIsOfAMachineThatMovesPlus) {
  const auto pretravel = With("probe_pretravel", "x+", {0.03});

  EXPECT_NEAR(Touch_mm(pretravel, {100, 0, 0}, -kX), -0.03, kExact);
  EXPECT_NEAR(Touch_mm(pretravel, {100, 0, 0}, kX), -0.02, kExact);
}

TEST(Signs, PretravelBetweenAxesIsAnEllipse) {
  const auto pretravel = With("probe_pretravel", "x", {0.03});
  const Vec3<double> n = Vec3<double>(1, 1, 0).normalized();

  const double expected_mm = std::sqrt(2.0) / std::hypot(1 / 0.03, 1 / 0.02);
  EXPECT_NEAR(Touch_mm(pretravel, {100, 0, 0}, n), -expected_mm, kExact);
}

TEST(Signs, LatencyReadsMinusFeedTimesTime) {
  EXPECT_NEAR(Touch_mm(With("trigger_latency", "", {1.5}), {0, 0, 0}, kX),
              -0.02 - 2 * 0.0015,
              kExact);
}

TEST(Signs, ATooLargeTipReadsPlus) {
  EXPECT_NEAR(
      Touch_mm(With("tip_size", "", {0.25}), {0, 0, 0}, kX), 0.25 - 0.02, kExact);
}

TEST(Signs, WindupLagsByHalfTheLostMotion) {
  const double half_mm = 8 * 0.5e-3 / 2;  // 8 N of rail friction, 0.5 um/N.

  EXPECT_NEAR(
      Position_mm(With("windup_load", "x", {0.5}), {9, 0, 0}, kX), -half_mm, kExact);
}

TEST(Signs, WindupFollowsTheLoadWhereItIsKnown) {
  const At at{.kind = RowKind::kPosition, .dir = {1, 0, 0}, .n = kX, .load_n = 100};

  EXPECT_NEAR(Predict_mm<double>(Gantry(), at, With("windup_load", "x", {0.5})),
              -0.025,
              kExact);
}

TEST(Signs, SquarenessIsRightHandedAboutTheFirstLetter) {
  const double angle_rad = 1e-3;
  const double neglected =
      angle_rad * angle_rad * 150;  // Second order over half the travel.

  const auto c0y = With("squareness", "C0Y", {1});
  EXPECT_NEAR(Position_mm(c0y, {0, 250, 0}, kX), -angle_rad * 100, neglected);
  const auto b0z = With("squareness", "B0Z", {1});
  EXPECT_NEAR(Position_mm(b0z, {0, 0, 110}, kX), +angle_rad * 50, neglected);
  const auto a0z = With("squareness", "A0Z", {1});
  EXPECT_NEAR(Position_mm(a0z, {0, 0, 110}, kY), -angle_rad * 50, neglected);
}

TEST(Signs, ATiltedBedIsHigherWhereItsSlopePoints) {
  const auto tilt = With("bed_tilt", "", {2, -1});

  const double flat_mm = Touch_mm({}, {250, 50, 0}, kZ, true);
  EXPECT_NEAR(Touch_mm(tilt, {250, 50, 0}, kZ, true) - flat_mm,
              0.002 * 100 + 0.001 * 100,
              kExact);
}

TEST(Signs, WhatDoesNotStandOnTheTableDoesNotTilt) {
  EXPECT_NEAR(
      Touch_mm(With("bed_tilt", "", {2, -1}), {250, 50, 0}, kZ, false), -0.02, kExact);
}

TEST(Signs, AWeightBeyondFrictionKeepsTheGapShut) {
  Machine machine = Gantry();
  machine.axes[2].counterbalance_n = 0;
  const At at{.kind = RowKind::kPosition,
              .dir = {0, 0, 1},
              .n = kZ,
              .steps_per_mm = {800, 800, 800}};

  EXPECT_NEAR(Predict_mm<double>(machine, at, With("backlash", "z", {0.1})), 0, kExact);
  EXPECT_NEAR(
      Predict_mm<double>(Gantry(), at, With("backlash", "z", {0.1})), -0.05, kExact);
}

TEST(Predict, ASquarenessOnAWrongScaleSeesWhereTheAxisTrulyIs) {
  auto effects = With("steps_per_mm", "y", {800 / 1.01});
  effects.push_back(With("squareness", "C0Y", {1})[0]);

  const double u_mm = 250 * 1.01 - 150;
  EXPECT_NEAR(Position_mm(effects, {0, 250, 0}, kX), -std::sin(1e-3) * u_mm, kExact);
}

}  // namespace
}  // namespace caltwin
