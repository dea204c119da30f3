#include <cmath>

#include <ceres/jet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/kinds/delta/foretold_mesh.h"
#include "calibration/kinds/delta/joint.h"
#include "calibration/kinds/delta/settings.h"
#include "sim/base/rng.h"
#include "sim/machine/kinds/delta/knobs.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/kinds/delta/simulated.h"
#include "sim/machine/kinds/delta/slopes.h"

namespace caltwin {
namespace {

DeltaModel<double> Believed() {
  return SymmetricDelta(300, 130, 250);
}

DeltaBuild<double> Drawn() {
  return {.model = Believed()};
}

// The machine on which public engines were compared.
DeltaBuild<double> Built() {
  DeltaBuild<double> build{.model = SymmetricDelta(300, 130.8, 250)};
  build.model.angle_rad[0] += 0.35 * kDegree;
  build.model.angle_rad[1] -= 0.25 * kDegree;
  build.model.endstop_mm = {300.30, 299.80, 300.45};
  return build;
}

// Eight at 100 mm, six at 50, the centre and one more: the same 16 for every engine.
std::vector<Vec3<double>> SixteenPoints() {
  std::vector<Vec3<double>> points;
  for (int i = 0; i < 8; ++i) {
    points.emplace_back(
        100 * std::cos(i * 45 * kDegree), 100 * std::sin(i * 45 * kDegree), 0);
  }
  for (int i = 0; i < 6; ++i) {
    const double angle = (15 + 60 * i) * kDegree;
    points.emplace_back(50 * std::cos(angle), 50 * std::sin(angle), 0);
  }
  points.emplace_back(0, 0, 0);
  points.emplace_back(20, 35, 0);
  return points;
}

// A centre and three rings of 6, 12 and 18.
std::vector<Vec3<double>> ThirtySevenPoints() {
  std::vector<Vec3<double>> points = {{0, 0, 0}};
  for (int ring = 1; ring <= 3; ++ring) {
    for (int i = 0; i < 6 * ring; ++i) {
      const double angle = 2 * M_PI * i / (6 * ring);
      points.emplace_back(
          100 * ring / 3.0 * std::cos(angle), 100 * ring / 3.0 * std::sin(angle), 0);
    }
  }
  return points;
}

DeltaReadings Touch(SimulatedDelta* machine,
                    const std::vector<Vec3<double>>& points,
                    double sigma_mm) {
  DeltaReadings readings;
  for (const Vec3<double>& at : points) {
    const auto motors = machine->Touch(Believed(), at[0], at[1]);
    if (motors) readings.touches.push_back({*motors, 0, std::max(sigma_mm, 1e-4)});
  }
  return readings;
}

// Of the height on the lattice that accuracies are taken on.
double MeanVariance_mm2(const DeltaJointFit& fit) {
  double sum = 0;
  int count = 0;
  for (int i = -8; i <= 8; ++i) {
    for (int j = -8; j <= 8; ++j) {
      if (i * i + j * j > 64) continue;
      const Vec3<double> motors =
          DeltaMotors_mm<double>(Believed(), {12.5 * i, 12.5 * j, 0});
      sum += std::pow(ForetellHeight(fit, motors).sd_mm, 2);
      ++count;
    }
  }
  return sum / count;
}

double Value(const DeltaJointFit& fit, std::string_view name) {
  for (const DeltaEstimate& one : fit.estimates) {
    if (kDeltaKnobs[static_cast<std::size_t>(one.knob)].name == name) return one.value;
  }
  return std::nan("");
}

TEST(DeltaJoint, RecoversWhatThreeRodsKnow) {
  SimulatedDelta machine(Built(), {.slope_x = 0.002, .slope_y = -0.001}, 0, 1);
  const DeltaReadings readings = Touch(&machine, SixteenPoints(), 0);
  const DeltaJointFit fit = FitDeltaJointly(Drawn(), readings);

  EXPECT_TRUE(fit.converged);
  EXPECT_NEAR(Value(fit, "delta_radius"), 0.8, 2e-3);
  EXPECT_NEAR(Value(fit, "tower_angle.a"), 0.35, 1e-3);
  EXPECT_NEAR(Value(fit, "tower_angle.b"), -0.25, 1e-3);
  EXPECT_NEAR(Value(fit, "bed_tilt.slope_x_mrad"), 2, 0.05);
  EXPECT_LT(fit.hold_out_mm, 2e-6);
}

// The drawing says where the effector's joints are, so a tower that stands round twists
// its carriage: six numbers and no twist tell it all the same.
TEST(DeltaJoint, RecoversTowersThatStandRound) {
  DeltaBuild<double> drawn = Drawn();
  drawn.twist_per_angle = TwistPerAngle(drawn.model, drawn.effector_radius_mm);
  DeltaBuild<double> built = drawn;
  StandRound(0, 0.35 * kDegree, &built);
  StandRound(1, -0.25 * kDegree, &built);
  SimulatedDelta machine(built, {}, 0, 1);
  const DeltaReadings readings = Touch(&machine, ThirtySevenPoints(), 0);
  const std::vector<int> six = {0, 1, 2, 3, 4, 5};
  const DeltaJointFit fit = FitDeltaJointly(drawn, readings, {.knobs = six});
  const DeltaJointFit without = FitDeltaJointly(Drawn(), readings, {.knobs = six});

  const double per_angle = drawn.twist_per_angle;
  EXPECT_NEAR(Value(fit, "tower_angle.a"), 0.35 / per_angle, 1e-3);
  EXPECT_NEAR(Value(fit, "tower_angle.b"), -0.25 / per_angle, 1e-3);
  EXPECT_LT(fit.rms_mm, 1e-4);
  EXPECT_GT(without.rms_mm, 10 * fit.rms_mm);
  // From settings that have the angles already there is nothing to find.
  const DeltaJointFit again =
      FitDeltaJointly(WithSettings(drawn, fit.build.model), readings, {.knobs = six});
  EXPECT_NEAR(Value(again, "tower_angle.a"), 0, 1e-4);
}

// What 10 um of noise in 16 touches leaves of six unknowns, over the disc: the mean
// variance foretold by the covariance is the least there can be.
TEST(DeltaJoint, ReachesTheLeastSquaresOptimum) {
  const DeltaJointOptions options{.knobs = {0, 1, 2, 3, 4, 5}, .huber_sigma = 0};
  double square = 0, least = 0;
  constexpr int kDraws = 200;
  for (int draw = 0; draw < kDraws; ++draw) {
    SimulatedDelta machine(Built(), {}, 0.010, 100 + static_cast<std::uint64_t>(draw));
    const DeltaReadings readings = Touch(&machine, SixteenPoints(), 0.010);
    const DeltaJointFit fit = FitDeltaJointly(Drawn(), readings, options);
    const double rms = DeltaAccuracyOf(Built(), {}, fit.build.model, 100).z_rms_mm;
    square += rms * rms / kDraws;
    least += MeanVariance_mm2(fit) / kDraws;
  }
  EXPECT_NEAR(std::sqrt(square / least), 1, 0.1);  // 200 draws tell it to 3 %.
  EXPECT_NEAR(std::sqrt(least), 0.0054, 0.0001);
}

TEST(DeltaJoint, StatedUncertaintiesAreTheScatter) {
  constexpr int kDraws = 200;
  const std::vector<int> knobs = {0, 1, 2, 3, 4, 5};
  Eigen::VectorXd square = Eigen::VectorXd::Zero(6), stated = square;
  const std::vector<double> truth = {0.3, -0.2, 0.45, 0.8, 0.35, -0.25};
  for (int draw = 0; draw < kDraws; ++draw) {
    SimulatedDelta machine(Built(), {}, 0.010, 900 + static_cast<std::uint64_t>(draw));
    const DeltaJointFit fit = FitDeltaJointly(Drawn(),
                                              Touch(&machine, SixteenPoints(), 0.010),
                                              {.knobs = knobs, .huber_sigma = 0});
    for (int k = 0; k < 6; ++k) {
      const auto& one = fit.estimates[static_cast<std::size_t>(k)];
      square[k] += std::pow(one.value - truth[static_cast<std::size_t>(k)], 2) / kDraws;
      stated[k] = one.sd;
    }
  }
  // 200 draws tell a standard deviation to 5 %.
  for (int k = 0; k < 6; ++k)
    EXPECT_NEAR(std::sqrt(square[k]) / stated[k], 1, 0.2) << k;
}

// 288 mm rods "calibrated" to 270: what heights cannot tell, a calliper on them does.
TEST(DeltaJoint, HeightsAloneDoNotTellTheRodsAndItSaysSo) {
  DeltaBuild<double> longer = Built();
  longer.model.arm_mm.fill(250.6);
  SimulatedDelta machine(longer, {}, 0.010, 7);
  const DeltaReadings readings = Touch(&machine, SixteenPoints(), 0.010);
  std::vector<double> free_rods;
  for (const DeltaKnob& knob : kDeltaKnobs) free_rods.push_back(knob.prior_sd);
  free_rods[6] = 20;
  const DeltaJointOptions six{.knobs = {0, 1, 2, 3, 4, 5}};
  const DeltaJointOptions seven{.knobs = {0, 1, 2, 3, 4, 5, 6}, .prior_sd = free_rods};
  const DeltaJointFit without = FitDeltaJointly(Drawn(), readings, six);
  const DeltaJointFit with = FitDeltaJointly(Drawn(), readings, seven);

  // The radius is five times less sure once the rods may be any length.
  EXPECT_GT(with.estimates[3].sd, 3 * without.estimates[3].sd);
  EXPECT_GT(with.estimates[6].sd, 0.2);
  // A print measured by calliper tells them.
  DeltaReadings measured = readings;
  for (const double angle_deg : {0.0, 60.0, 120.0}) {
    const Vec3<double> out(
        80 * std::cos(angle_deg * kDegree), 80 * std::sin(angle_deg * kDegree), 0);
    const Vec3<double> from = DeltaMotors_mm<double>(Believed(), out);
    const Vec3<double> to = DeltaMotors_mm<double>(Believed(), -out);
    measured.distances.push_back({.length_mm = (DeltaPoseOf(longer, from)->nozzle_mm -
                                                DeltaPoseOf(longer, to)->nozzle_mm)
                                                   .norm(),
                                  .from_mm = from,
                                  .to_mm = to,
                                  .sigma_mm = 0.02});
  }
  const DeltaJointFit told = FitDeltaJointly(Drawn(), measured, seven);
  EXPECT_LT(told.estimates[6].sd, 0.5 * with.estimates[6].sd);
  EXPECT_NEAR(told.estimates[6].value, 0.6, 4 * told.estimates[6].sd);
}

TEST(DeltaJoint, AnOutlierCostsLittle) {
  SimulatedDelta machine(Built(), {}, 0.005, 3);
  DeltaReadings readings = Touch(&machine, ThirtySevenPoints(), 0.005);
  Vec3<double> at = DeltaNozzle_mm(Believed(), readings.touches[5].motors_mm);
  at[2] += 0.3;
  readings.touches[5].motors_mm = DeltaMotors_mm<double>(Believed(), at);
  const DeltaJointFit fit = FitDeltaJointly(Drawn(), readings);

  const DeltaModel<double> settings =
      BestDeltaSettings(fit.build, fit.bed, Believed(), 100);
  EXPECT_LT(DeltaAccuracyOf(Built(), {}, settings, 100).z_rms_mm, 0.005);
}

// Every error at once; settings of three rods that print best are taken from the fit.
// With the settings that firmwares have: one radius for all towers. Heights against
// their mean, which a Z offset takes.
TEST(DeltaJoint, ThirtySevenTouchesOfAnyMachineLeaveItFlat) {
  Rng rng(5, 0, "delta.any");
  double one_radius2 = 0, three_radii2 = 0, mesh2 = 0;
  constexpr int kMachines = 20;
  for (int m = 0; m < kMachines; ++m) {
    DeltaBuild<double> build = Drawn();
    DeltaBed<double> bed;
    for (const int knob : MachineKnobs()) {
      const DeltaKnob& is = kDeltaKnobs[static_cast<std::size_t>(knob)];
      TurnKnob(knob, 0.5 * is.prior_sd * is.per_unit * rng.Normal(), &build, &bed);
    }
    SimulatedDelta machine(build, bed, 0.005, 40 + static_cast<std::uint64_t>(m));
    const DeltaReadings readings = Touch(&machine, ThirtySevenPoints(), 0.005);
    const DeltaJointFit fit =
        FitDeltaJointly(Drawn(), readings, {.knobs = MachineKnobs()});
    ASSERT_TRUE(fit.converged) << m;
    const auto flat2 = [&](bool has_radius_per_tower) {
      const DeltaModel<double> settings =
          BestDeltaSettings(fit.build,
                            fit.bed,
                            Believed(),
                            100,
                            {.has_radius_per_tower = has_radius_per_tower});
      const double rms = DeltaAccuracyOf(build, bed, settings, 100).z_flat_rms_mm;
      return rms * rms / kMachines;
    };
    one_radius2 += flat2(false);
    three_radii2 += flat2(true);
    const DeltaModel<double> settings = BestDeltaSettings(
        fit.build, fit.bed, Believed(), 100, {.has_radius_per_tower = false});
    const DeltaMesh mesh = ForetoldMesh(fit, settings, 100, 7);
    const double left = DeltaAccuracyOf(build, bed, settings, 100, mesh).z_flat_rms_mm;
    mesh2 += left * left / kMachines;
  }
  RecordProperty("one_radius_um", std::to_string(1e3 * std::sqrt(one_radius2)));
  RecordProperty("three_radii_um", std::to_string(1e3 * std::sqrt(three_radii2)));
  RecordProperty("mesh_um", std::to_string(1e3 * std::sqrt(mesh2)));
  EXPECT_LT(std::sqrt(one_radius2), 0.010);
  EXPECT_LT(std::sqrt(mesh2), 0.003);  // Less than one touch scatters by.
  EXPECT_LT(std::sqrt(three_radii2), std::sqrt(one_radius2) + 1e-4);
}

TEST(DeltaJoint, TouchesChosenOneByOneTellMoreThanTheSixteen) {
  const std::vector<int> knobs = {0, 1, 2, 3, 4, 5};
  const DeltaJointOptions options{.knobs = knobs};
  SimulatedDelta machine(Built(), {}, 0.010, 8);
  DeltaReadings chosen;
  for (int i = 0; i < 16; ++i) {
    const DeltaJointFit so_far = FitDeltaJointly(Drawn(), chosen, options);
    const Vec3<double> next = BestNextTouch(so_far, Believed(), 100, 0.010);
    chosen.touches.push_back({*machine.Touch(Believed(), next[0], next[1]), 0, 0.010});
  }
  const DeltaJointFit by_choice = FitDeltaJointly(Drawn(), chosen, options);
  const DeltaJointFit by_plan =
      FitDeltaJointly(Drawn(), Touch(&machine, SixteenPoints(), 0.010), options);
  const auto rms_um = [](const DeltaJointFit& fit) {
    return 1e3 * std::sqrt(MeanVariance_mm2(fit));
  };
  RecordProperty("chosen_um", std::to_string(rms_um(by_choice)));
  RecordProperty("sixteen_um", std::to_string(rms_um(by_plan)));
  EXPECT_LT(rms_um(by_choice), rms_um(by_plan));
}

// The adjoint against automatic differentiation of the chain itself.
TEST(ClosedDelta, ItsSlopesAreThoseOfTheChain) {
  using Jet = ceres::Jet<double, kNumDeltaKnobs>;
  Rng rng(11, 0, "delta.slopes");
  DeltaBuild<double> build = Built();
  DeltaBed<double> bed;
  DeltaBuild<Jet> free_build;
  DeltaBed<Jet> free_bed;
  build.twist_per_angle = free_build.twist_per_angle = 0.8;
  for (std::size_t i = 0; i < 3; ++i) {
    free_build.model.endstop_mm[i] = Jet(build.model.endstop_mm[i]);
    free_build.model.radius_mm[i] = Jet(build.model.radius_mm[i]);
    free_build.model.angle_rad[i] = Jet(build.model.angle_rad[i]);
    free_build.model.arm_mm[i] = Jet(build.model.arm_mm[i]);
  }
  for (int k = 0; k < kNumDeltaKnobs; ++k) {
    const DeltaKnob& knob = kDeltaKnobs[static_cast<std::size_t>(k)];
    const double by = 0.5 * knob.prior_sd * knob.per_unit * rng.Normal();
    TurnKnob(k, by, &build, &bed);
    TurnKnob(k, Jet(by, k), &free_build, &free_bed);
  }
  for (const Vec3<double>& at : SixteenPoints()) {
    const Vec3<double> motors = DeltaMotors_mm<double>(Believed(), at);
    const auto pose = DeltaPoseOf<Jet>(free_build, motors.cast<Jet>());
    ASSERT_TRUE(pose);
    const Jet height =
        pose->nozzle_mm[2] - free_bed.Height_mm(pose->nozzle_mm[0], pose->nozzle_mm[1]);
    std::array<double, kNumDeltaKnobs> slopes{};
    const auto closed = ClosedDelta::At(build, motors);
    ASSERT_TRUE(closed);
    EXPECT_NEAR(closed->HeightOver(bed, &slopes), height.a, 1e-9);
    for (int k = 0; k < kNumDeltaKnobs; ++k) {
      EXPECT_NEAR(slopes[static_cast<std::size_t>(k)],
                  height.v[k],
                  1e-9 * (1 + std::abs(height.v[k])))
          << kDeltaKnobs[static_cast<std::size_t>(k)].name;
    }
  }
}

TEST(DeltaSettings, AreTheMachinesOwnWhereThreeRodsSuffice) {
  const DeltaModel<double> settings = BestDeltaSettings(Built(), {}, Believed(), 100);
  const DeltaAccuracy accuracy = DeltaAccuracyOf(Built(), {}, settings, 100);

  EXPECT_LT(accuracy.z_rms_mm, 1e-6);
  EXPECT_LT(accuracy.xy_rms_mm, 1e-5);
  EXPECT_LT(std::abs(accuracy.xy_scale), 1e-7);
}

TEST(DeltaKnobs, ReadWhatTheyWereTurned) {
  DeltaBuild<double> drawn = Drawn();
  drawn.twist_per_angle = 0.8;
  for (int knob = 0; knob < kNumDeltaKnobs; ++knob) {
    DeltaBuild<double> build = drawn;
    DeltaBed<double> bed;
    const DeltaKnob& turned = kDeltaKnobs[static_cast<std::size_t>(knob)];
    TurnKnob(knob, 0.25 * turned.per_unit, &build, &bed);
    for (int other = 0; other < kNumDeltaKnobs; ++other) {
      // All towers moved out together are no tower's own.
      EXPECT_NEAR(KnobValue(other, build, bed, drawn), other == knob ? 0.25 : 0, 1e-7)
          << turned.name << " read as "
          << kDeltaKnobs[static_cast<std::size_t>(other)].name;
    }
  }
}

TEST(DeltaSettings, CountAnglesFromTheDrawing) {
  DeltaModel<double> turned = Built().model;
  DeltaModel<double> drawn = Believed();
  for (double& angle : turned.angle_rad) angle += RadFromDeg(30.0);
  for (double& angle : drawn.angle_rad) angle += RadFromDeg(30.0);

  EXPECT_EQ(AsMarlin(turned, drawn), AsMarlin(Built().model, Believed()));
}

TEST(DeltaSettings, AreWrittenAsFirmwaresReadThem) {
  DeltaModel<double> model = Built().model;

  const DeltaModel<double> drawn = Believed();

  EXPECT_EQ(AsMarlin(model, drawn),
            "M665 L250.0000 R130.8000 H299.8000 X0.3500 Y-0.2500 Z0.0000 A0.0000 "
            "B0.0000 C0.0000\nM666 X-0.5000 Y0.0000 Z-0.6500\n");
  EXPECT_EQ(AsRrf(model, drawn),
            "M665 L250.0000 R130.8000 H300.1833 X0.3500 Y-0.2500 Z0.0000\n"
            "M666 X0.1167 Y-0.3833 Z0.2667\n");
  EXPECT_THAT(AsKlipper(model), ::testing::HasSubstr("position_endstop: 299.800000"));
}

}  // namespace
}  // namespace caltwin
