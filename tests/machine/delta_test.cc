#include <cmath>

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "sim/base/rng.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {
namespace {

DeltaBuild<double> Drawn() {
  return {.model = SymmetricDelta(300, 130, 250)};
}

Vec3<double> RandomPoint(Rng* rng) {
  const double radius = 100 * std::sqrt(rng->Uniform());
  const double angle = 2 * M_PI * rng->Uniform();
  return {radius * std::cos(angle), radius * std::sin(angle), 100 * rng->Uniform()};
}

TEST(Delta, ANozzleAtTheOriginNeedsTheEndstopsOwnTravel) {
  const DeltaModel<double> model = SymmetricDelta(300, 130, 250);

  EXPECT_TRUE(DeltaMotors_mm<double>(model, {0, 0, 0})
                  .isApprox(Vec3<double>::Constant(300), 1e-14));
  EXPECT_LT(DeltaMotors_mm<double>(model, {0, 0, 300}).norm(), 1e-12);
}

TEST(Delta, ThreeRodFormulasInvertEachOther) {
  Rng rng(1, 0, "delta");
  DeltaModel<double> model = SymmetricDelta(300, 130, 250);
  model.radius_mm = {130.8, 129.5, 130.1};
  model.angle_rad[0] += 0.01;
  model.arm_mm = {250.4, 249.9, 250};
  model.endstop_mm = {300.3, 299.8, 300.4};
  for (int i = 0; i < 100; ++i) {
    const Vec3<double> at = RandomPoint(&rng);
    EXPECT_LT((DeltaNozzle_mm(model, DeltaMotors_mm(model, at)) - at).norm(), 1e-10);
  }
}

// Parallel rods of equal length make the effector a translation: six rods are three.
TEST(Delta, SixRodsAsDrawnAreThree) {
  Rng rng(2, 0, "delta");
  DeltaBuild<double> build = Drawn();
  build.model.radius_mm = {130.8, 129.5, 130.1};
  build.model.angle_rad[1] -= 0.004;
  build.model.arm_mm = {250.4, 249.9, 250};
  for (int i = 0; i < 100; ++i) {
    const Vec3<double> at = RandomPoint(&rng);
    const auto pose = DeltaPoseOf<double>(build, DeltaMotors_mm(build.model, at));
    ASSERT_TRUE(pose);
    EXPECT_LT((pose->nozzle_mm - at).norm(), 1e-9);
    EXPECT_LT(pose->cayley.norm(), 1e-12);
  }
}

TEST(Delta, AClosedChainHasRodsOfTheirLength) {
  Rng rng(3, 0, "delta");
  DeltaBuild<double> build = Drawn();
  build.rod_error_mm = {0.3, -0.2, 0.1, 0, -0.4, 0.2};
  build.lean_radial_rad = {0.003, -0.002, 0.001};
  build.lean_tangential_rad = {-0.002, 0.001, 0.004};
  build.twist_rad = {0.01, -0.02, 0.005};
  build.belt_scale = {0.001, 0, -0.002};
  for (int i = 0; i < 100; ++i) {
    const Vec3<double> motors = DeltaMotors_mm(build.model, RandomPoint(&rng));
    const auto pose = DeltaPoseOf(build, motors);
    ASSERT_TRUE(pose);
    const auto upper = delta_chain::UpperJoints_mm(build, motors);
    const auto lower = delta_chain::LowerJoints_mm(build);
    for (std::size_t k = 0; k < 6; ++k) {
      const double length_mm =
          (pose->nozzle_mm + delta_chain::Rotated(pose->cayley, lower[k]) - upper[k])
              .norm();
      EXPECT_NEAR(length_mm, 250 + build.rod_error_mm[k], 1e-10);
    }
    EXPECT_GT(pose->cayley.norm(), 1e-4);  // The effector tilts.
  }
}

TEST(Delta, MotorsOfTheChainPutTheNozzleThere) {
  DeltaBuild<double> build = Drawn();
  build.rod_error_mm = {0.3, -0.2, 0.1, 0, -0.4, 0.2};
  const Vec3<double> at(40, -60, 12);
  const auto motors = DeltaMotorsOf(build, at);
  ASSERT_TRUE(motors);

  EXPECT_LT((DeltaPoseOf(build, *motors)->nozzle_mm - at).norm(), 1e-9);
}

// The nozzle hangs 20 mm below joints 40 mm apart: the tilt moves it as much again.
TEST(Delta, OneRodATenthLongMovesTheNozzleByAboutAsMuch) {
  DeltaBuild<double> build = Drawn();
  build.rod_error_mm[0] = 0.1;
  double most_xy_mm = 0, most_z_mm = 0;
  for (int x = -100; x <= 100; x += 20) {
    for (int y = -100; y <= 100; y += 20) {
      const Vec3<double> at(x, y, 0);
      if (at.norm() > 100) continue;
      const auto pose = DeltaPoseOf<double>(build, DeltaMotors_mm(build.model, at));
      const Vec3<double> off = pose->nozzle_mm - at;
      most_xy_mm = std::max(most_xy_mm, std::hypot(off[0], off[1]));
      most_z_mm = std::max(most_z_mm, std::abs(off[2]));
    }
  }
  EXPECT_GT(most_xy_mm, 0.04);
  EXPECT_LT(most_xy_mm, 0.15);
  EXPECT_LT(most_z_mm, 0.08);
}

// By differences and by automatic differentiation, of every kind of error.
TEST(Delta, DerivativesAreThoseOfDifferences) {
  using Jet = ceres::Jet<double, 8>;
  DeltaBuild<double> plain = Drawn();
  plain.rod_error_mm = {0.3, -0.2, 0.1, 0, -0.4, 0.2};
  DeltaBuild<Jet> build;
  for (std::size_t i = 0; i < 3; ++i) {
    build.model.endstop_mm[i] = Jet(plain.model.endstop_mm[i]);
    build.model.radius_mm[i] = Jet(plain.model.radius_mm[i]);
    build.model.angle_rad[i] = Jet(plain.model.angle_rad[i]);
    build.model.arm_mm[i] = Jet(plain.model.arm_mm[i]);
  }
  for (std::size_t k = 0; k < 6; ++k)
    build.rod_error_mm[k] = Jet(plain.rod_error_mm[k]);
  const auto knob = [](auto* b, int which) -> auto& {
    switch (which) {
      case 0:
        return b->model.endstop_mm[0];
      case 1:
        return b->model.radius_mm[1];
      case 2:
        return b->model.angle_rad[2];
      case 3:
        return b->rod_error_mm[1];
      case 4:
        return b->lean_radial_rad[0];
      case 5:
        return b->twist_rad[1];
      case 6:
        return b->belt_scale[2];
      default:
        return b->tool_tilt_x_rad;
    }
  };
  for (int k = 0; k < 8; ++k) knob(&build, k).v[k] = 1;
  const Vec3<double> motors = DeltaMotors_mm<double>(plain.model, {50, 30, 5});
  const auto pose = DeltaPoseOf<Jet>(build, motors.cast<Jet>());
  ASSERT_TRUE(pose);
  for (int k = 0; k < 8; ++k) {
    const double step = k == 0 || k == 1 || k == 3 ? 1e-4 : 1e-6;
    DeltaBuild<double> more = plain, less = plain;
    knob(&more, k) += step;
    knob(&less, k) -= step;
    const Vec3<double> slope =
        (DeltaPoseOf(more, motors)->nozzle_mm - DeltaPoseOf(less, motors)->nozzle_mm) /
        (2 * step);
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(pose->nozzle_mm[i].v[k], slope[i], 1e-5 * (1 + std::abs(slope[i])))
          << k;
    }
  }
}

TEST(Delta, NamesOfTowersAndRods) {
  EXPECT_EQ(RodName(*RodNamed("b2")), "b2");
  EXPECT_EQ(*TowerNamed("c"), 2);
  EXPECT_FALSE(RodNamed("d1"));
  EXPECT_FALSE(TowerNamed("ab"));
}

}  // namespace
}  // namespace caltwin
