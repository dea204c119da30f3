// What a joint estimate makes of lengths, priors and any subset of its unknowns, and
// when its settings are worth setting.

#include <cmath>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/kinds/delta/change.h"
#include "calibration/kinds/delta/rrf_least_squares.h"
#include "calibration/kinds/delta/settings.h"
#include "sim/base/rng.h"
#include "sim/machine/kinds/delta/knobs.h"
#include "sim/machine/kinds/delta/model.h"
#include "tests/calibration/delta_engine_rows.h"

namespace caltwin {
namespace {

using delta_rows::Believed;
using delta_rows::Built;

const DeltaBuild<double> kDrawn{.model = Believed()};

DeltaReadings Touched(const DeltaBuild<double>& build,
                      double sigma_mm,
                      std::uint64_t seed) {
  SimulatedDelta machine(build, {}, sigma_mm, seed);
  DeltaReadings readings;
  for (const Eigen::Vector2d& at : RrfProbePoints(100)) {
    readings.touches.push_back({.motors_mm = *machine.Touch(Believed(), at[0], at[1]),
                                .sigma_mm = std::max(sigma_mm, 1e-3)});
  }
  return readings;
}

void ReadRods(const DeltaBuild<double>& build,
              double sigma_mm,
              Rng* rng,
              DeltaReadings* readings) {
  for (int rod = 0; rod < kNumRods; ++rod) {
    const auto at = static_cast<std::size_t>(rod);
    readings->rods.push_back({.rod = rod,
                              .length_mm = build.model.arm_mm[at / 2] +
                                           build.rod_error_mm[at] +
                                           sigma_mm * rng->Normal(),
                              .sigma_mm = std::max(sigma_mm, 1e-3)});
  }
}

std::vector<int> Named(const std::vector<std::string>& names) {
  return DeltaKnobsNamed(names);
}

const DeltaEstimate& Of(const DeltaJointFit& fit, std::string_view name) {
  for (const DeltaEstimate& one : fit.estimates) {
    if (kDeltaKnobs[static_cast<std::size_t>(one.knob)].name == name) return one;
  }
  throw std::logic_error("not among the estimates");
}

double Scale_um_per_mm(const DeltaBuild<double>& build, const DeltaJointFit& fit) {
  const auto settings = BestDeltaSettings(fit.build, fit.bed, Believed(), 100);
  return 1e3 * std::abs(DeltaAccuracyOf(build, {}, settings, 100).xy_scale);
}

// Rods 0.6 mm longer than drawn, and unlike: heights are flat and prints 0.2 % wrong
// until somebody holds a calliper to the rods.
TEST(DeltaJointLengths, RodsByCalliperTellTheSizeOfPrints) {
  DeltaBuild<double> build = Built(250.6);
  build.rod_error_mm = {0.1, -0.1, 0.05, 0, -0.08, 0.06};
  DeltaReadings readings = Touched(build, 0, 1);
  const DeltaJointOptions options{.knobs = MachineKnobs()};
  const double without =
      Scale_um_per_mm(build, FitDeltaJointly(kDrawn, readings, options));
  Rng none(1, 0, "none");
  ReadRods(build, 0, &none, &readings);
  const DeltaJointFit fit = FitDeltaJointly(kDrawn, readings, options);

  EXPECT_GT(without, 1);
  EXPECT_LT(Scale_um_per_mm(build, fit), 0.05);
  for (int rod = 0; rod < kNumRods; ++rod) {
    const auto at = static_cast<std::size_t>(rod);
    EXPECT_NEAR(fit.build.model.arm_mm[at / 2] + fit.build.rod_error_mm[at],
                250.6 + build.rod_error_mm[at],
                0.002)
        << RodName(rod);
  }
}

TEST(DeltaJointLengths, RodLengthsScatterAsStated) {
  constexpr int kDraws = 200;
  const std::vector<int> knobs =
      Named({"endstop.a", "endstop.b", "endstop.c", "delta_radius", "arm_length"});
  Rng rng(3, 0, "rods");
  double square = 0, stated = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    DeltaReadings readings =
        Touched(Built(), 0.01, 50 + static_cast<std::uint64_t>(draw));
    ReadRods(Built(), 0.02, &rng, &readings);
    DeltaJointOptions options{.knobs = knobs, .huber_sigma = 0};
    options.prior_sd.assign(kNumDeltaKnobs, std::numeric_limits<double>::infinity());
    DeltaBuild<double> drawn = kDrawn;  // All but what is fitted is known.
    drawn.model.angle_rad = Built().model.angle_rad;
    const DeltaJointFit fit = FitDeltaJointly(drawn, readings, options);
    const DeltaEstimate& arm = Of(fit, "arm_length");
    square += arm.value * arm.value / kDraws;
    stated += arm.sd * arm.sd / kDraws;
  }

  // Six readings of 0.02 mm; the touches add next to nothing.
  EXPECT_NEAR(std::sqrt(stated), 0.02 / std::sqrt(6.0), 1e-4);
  EXPECT_NEAR(std::sqrt(square / stated), 1, 4 / std::sqrt(2.0 * kDraws));
}

TEST(DeltaJointLengths, APriorIsAReadingToo) {
  const DeltaBuild<double> build = Built(250.6);
  DeltaJointOptions options{.knobs = Named({"endstop.a",
                                            "endstop.b",
                                            "endstop.c",
                                            "delta_radius",
                                            "tower_angle.a",
                                            "tower_angle.b",
                                            "arm_length"})};
  for (const DeltaKnob& knob : kDeltaKnobs) options.prior_sd.push_back(knob.prior_sd);
  options.prior_mean.assign(kNumDeltaKnobs, 0);
  options.prior_sd[kArmKnob] = 0.005;
  options.prior_mean[kArmKnob] = 0.6;
  const DeltaJointFit fit = FitDeltaJointly(kDrawn, Touched(build, 0, 1), options);

  EXPECT_NEAR(Of(fit, "arm_length").value, 0.6, 0.002);
  EXPECT_LT(Of(fit, "arm_length").sd, 0.005);
  EXPECT_NEAR(Of(fit, "delta_radius").value, 0.8, 0.01);
}

// What a prior adds to an estimate is how far that moves when the prior's mean is moved
// by its standard deviation: by fits of their own, not by the covariance.
TEST(DeltaJointLengths, BudgetsAreWhatMovedInputsDo) {
  DeltaReadings readings = Touched(Built(), 0.02, 5);
  Rng rng(6, 0, "rods");
  ReadRods(Built(), 0.02, &rng, &readings);
  DeltaJointOptions options{.knobs = Named({"endstop.a",
                                            "endstop.b",
                                            "endstop.c",
                                            "delta_radius",
                                            "tower_angle.a",
                                            "tower_angle.b",
                                            "arm_length"}),
                            .huber_sigma = 0};
  for (const DeltaKnob& knob : kDeltaKnobs) options.prior_sd.push_back(knob.prior_sd);
  options.prior_sd[kArmKnob] = 0.01;
  options.prior_mean.assign(kNumDeltaKnobs, 0);
  const DeltaJointFit fit = FitDeltaJointly(kDrawn, readings, options);
  options.prior_mean[kArmKnob] = 0.01;
  const DeltaJointFit moved = FitDeltaJointly(kDrawn, readings, options);

  for (std::size_t i = 0; i < fit.estimates.size(); ++i) {
    const DeltaEstimate& one = fit.estimates[i];
    double variance = 0, arm_u = 0;
    for (const Contribution& input : one.budget) {
      variance += input.u * input.u;
      if (input.input == "prior of arm_length") arm_u = input.u;
    }
    EXPECT_NEAR(std::sqrt(variance) / one.sd, 1, 1e-9) << one.knob;
    // To a thousandth of the variance it is among the other priors.
    if (arm_u == 0) continue;
    EXPECT_NEAR(std::abs(moved.estimates[i].value - one.value) / arm_u, 1, 0.02)
        << one.knob;
  }
  std::vector<std::string> of_arm;
  for (const Contribution& input : Of(fit, "arm_length").budget) {
    of_arm.push_back(input.input);
  }
  EXPECT_THAT(
      of_arm,
      ::testing::IsSupersetOf({"touches", "rods by calliper", "prior of arm_length"}));
}

TEST(DeltaJointLengths, WhatIsNotFittedStaysAsDrawn) {
  const DeltaJointFit fit = FitDeltaJointly(
      kDrawn, Touched(Built(), 0, 1), {.knobs = Named({"delta_radius", "endstop.c"})});

  ASSERT_EQ(fit.estimates.size(), 2U);
  EXPECT_EQ(fit.covariance.rows(), 2);
  EXPECT_EQ(fit.build.model.endstop_mm[0], 300);
  EXPECT_EQ(fit.build.model.angle_rad, Believed().angle_rad);
  EXPECT_NE(fit.build.model.radius_mm[0], 130);
}

// One touch more at the place advised leaves heights surer than at any other place
// tried.
TEST(DeltaJointLengths, TheNextTouchAdvisedTellsMost) {
  const DeltaReadings readings = Touched(Built(), 0.01, 1);
  const DeltaJointFit fit = FitDeltaJointly(kDrawn, readings);
  const auto left_mm2 = [&](const Vec3<double>& at) {
    DeltaReadings more = readings;
    more.touches.push_back(
        {.motors_mm = DeltaMotors_mm(fit.build.model, at), .sigma_mm = 0.01});
    const DeltaJointFit then = FitDeltaJointly(kDrawn, more);
    double sum = 0;
    for (const Eigen::Vector2d& place : RrfProbePoints(100)) {
      const Vec3<double> motors =
          DeltaMotors_mm<double>(Believed(), {place[0], place[1], 0});
      sum += std::pow(ForetellHeight(then, motors).sd_mm, 2);
    }
    return sum;
  };
  const double best = left_mm2(BestNextTouch(fit, Believed(), 100, 0.01));

  for (const Vec3<double>& other :
       {Vec3<double>(0, 0, 0), {50, 0, 0}, {0, 50, 0}, {-50, -50, 0}}) {
    EXPECT_LT(best, left_mm2(other));
  }
}

// Settings of one radius cannot hold unlike rods. What is lost is lost in heights and
// places, not in the size of all that is printed.
TEST(DeltaSettings, FlatnessIsNotBoughtWithSize) {
  DeltaBuild<double> build = Built();
  build.rod_error_mm = {0.2, -0.1, -0.25, 0.1, 0.05, 0.3};
  const auto settings = BestDeltaSettings(
      build, {.slope_x = 0.002}, Believed(), 100, {.has_radius_per_tower = false});
  const DeltaAccuracy left = DeltaAccuracyOf(build, {.slope_x = 0.002}, settings, 100);

  EXPECT_GT(left.z_rms_mm, 0.001);
  EXPECT_LT(std::abs(left.xy_scale), 0.01e-3);
}

// A second calibration of the same machine finds nothing worth setting; a machine that
// was moved is told.
TEST(DeltaChange, ChanceIsNotWorthSetting) {
  const DeltaJointFit first = FitDeltaJointly(kDrawn, Touched(Built(), 0.01, 1));
  const DeltaJointFit second = FitDeltaJointly(kDrawn, Touched(Built(), 0.01, 2));
  const auto best = [](const DeltaJointFit& fit) {
    return BestDeltaSettings(fit.build, fit.bed, Believed(), 100);
  };
  DeltaModel<double> moved = best(first);
  moved.endstop_mm[1] += 0.05;

  EXPECT_FALSE(ChangeOf(second, best(first), best(second), 100).IsTold());
  EXPECT_TRUE(ChangeOf(second, moved, best(second), 100).IsTold());
  EXPECT_TRUE(ChangeOf(first, Believed(), best(first), 100).IsTold());
}

TEST(DeltaChange, IsWhatTheOtherSettingsMoveTheNozzleBy) {
  const DeltaJointFit fit = FitDeltaJointly(kDrawn, Touched(Built(), 0, 1));
  DeltaModel<double> lower = fit.build.model;
  for (double& endstop_mm : lower.endstop_mm) endstop_mm -= 0.02;

  const DeltaChange change = ChangeOf(fit, fit.build.model, lower, 100);

  EXPECT_NEAR(change.scale.by, 0, 1e-7);
  EXPECT_NEAR(change.height_mm.by, 0.02, 1e-6);
  EXPECT_NEAR(change.place_mm.by, 0, 1e-6);
}

}  // namespace
}  // namespace caltwin
