#include <cmath>
#include <memory>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/units.h"
#include "sim/kinds/motor_stage/mechanism.h"
#include "sim/kinds/motor_stage/physics.h"

namespace caltwin {
namespace {

constexpr double kTick_s = MotorMechanism::kTick_s;
constexpr std::size_t kX = 0, kA = 3, kU = 4;

MotorStageDrawing Stage() {
  return MotorStageOf(
      ReadMachine(CALTWIN_SOURCE_DIR "/models/motor_stage/machine.yaml"));
}

BuiltMotors Built(double gap_unit = 0) {
  BuiltMotors motors;
  const MotorStageDrawing stage = Stage();
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    motors[i] = {.drawing = stage.axes[i], .gap_unit = gap_unit};
  }
  return motors;
}

std::unique_ptr<MotorMechanism> Make(const BuiltMotors& motors, bool is_physics) {
  if (!is_physics) return std::make_unique<FastMotors>(motors);
  return std::make_unique<PhysicsMotors>(Stage().model, motors);
}

// 20 units there and back as a cosine has it, a turning point in the middle.
double SwingAt(double t_s) {
  return 50 + 10 * (1 - std::cos(2 * std::numbers::pi * t_s / 0.8));
}

/// Largest difference [um, or thousandths of a degree] between two mechanisms.
struct Apart {
  double motor = 0, carriage = 0;
};

Apart Compare(const BuiltMotors& motors, std::size_t axis) {
  FastMotors fast(motors);
  PhysicsMotors physics(Stage().model, motors);
  MotorDrives drives{};
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    fast.Place(i, 50);
    physics.Place(i, 50);
    drives[i] = {MotorDrive::Mode::kFollow, 50};
  }
  Apart apart;
  for (int k = 1; k * kTick_s < 0.8; ++k) {
    drives[axis].to_unit = SwingAt(k * kTick_s);
    fast.Tick(drives);
    physics.Tick(drives);
    // The take-up of a gap is a knock that the play operator does not have.
    const double phase = std::fmod(k * kTick_s, 0.4);
    if (phase < 0.1 || phase > 0.38) continue;
    const MotorState a = fast.State(axis), b = physics.State(axis);
    apart.motor =
        std::max(apart.motor, UmFromMm(std::abs(a.motor_unit - b.motor_unit)));
    apart.carriage =
        std::max(apart.carriage, UmFromMm(std::abs(a.carriage_unit - b.carriage_unit)));
  }
  return apart;
}

TEST(MotorMechanism, FidelitiesAgreeWhereTheDriveFollows) {
  for (const std::size_t axis : {kX, kA, kU}) {
    const Apart apart = Compare(Built(), axis);
    RecordProperty("motor_um_" + MotorAxisName(axis), std::to_string(apart.motor));
    EXPECT_LT(apart.motor, 0.5) << MotorAxisName(axis);
    EXPECT_LT(apart.carriage, 0.5) << MotorAxisName(axis);
  }
}

TEST(MotorMechanism, FidelitiesAgreeAcrossAGap) {
  for (const std::size_t axis : {kX, kA}) {
    const Apart apart = Compare(Built(0.05), axis);
    EXPECT_LT(apart.motor, 0.5) << MotorAxisName(axis);
    EXPECT_LT(apart.carriage, 0.5) << MotorAxisName(axis);
  }
}

// A motor a third of its load is alone inside the gap: what its drive is tuned for must
// leave it at rest, not swing up (docs/motor-axes.md).
TEST(MotorMechanism, ADriveComesToRestAcrossAGap) {
  for (const double part : {0.3, 1.0, 3.0}) {
    BuiltMotors motors = Built(0.05);
    motors[kX].drawing.motor_inertia = part * motors[kX].drawing.load_inertia;
    const auto mechanism = Make(motors, /*is_physics=*/true);
    MotorDrives drives{};
    double to_unit = 0;
    for (int k = 0; k < 800; ++k) {
      to_unit += (k < 200 ? 40 : k < 400 ? -40 : 0) * kTick_s;
      drives[kX] = {MotorDrive::Mode::kFollow, to_unit};
      mechanism->Tick(drives);
    }

    // 0.1 s after its last way it stands. It may be left leaning on rail friction, off
    // by f dt^2 / M, as one is that does not integrate.
    const MotorAxisDrawing& d = motors[kX].drawing;
    const double leans_unit =
        d.friction * kTick_s * kTick_s / d.motor_inertia / d.si_per_unit();
    EXPECT_NEAR(mechanism->State(kX).motor_unit, to_unit, leans_unit) << part;
    EXPECT_LT(std::abs(mechanism->State(kX).motor_unit_s), 0.1) << part;
  }
}

class EitherFidelity : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(, EitherFidelity, ::testing::Bool());

// All the current: v / a with a = (F + friction) / M.
TEST_P(EitherFidelity, BrakingTakesAsLongAsInertiaAndCurrentHaveIt) {
  const BuiltMotors motors = Built();
  const auto mechanism = Make(motors, GetParam());
  const MotorAxisDrawing& d = motors[kX].drawing;
  mechanism->Place(kX, 0);
  MotorDrives drives{};
  double to_unit = 0, unit_s = 0;
  while (unit_s < 250) {
    to_unit += unit_s * kTick_s;
    drives[kX] = {MotorDrive::Mode::kFollow, to_unit};
    mechanism->Tick(drives);
    unit_s += 2500 * kTick_s;
  }
  const double start_unit_s = mechanism->State(kX).motor_unit_s;
  const double before_unit = mechanism->State(kX).motor_unit;

  drives[kX].mode = MotorDrive::Mode::kBrake;
  int ticks = 0;
  const double still_unit_s = 0.01 * start_unit_s;
  for (; ticks < 200 && std::abs(mechanism->State(kX).motor_unit_s) > still_unit_s;
       ++ticks) {
    mechanism->Tick(drives);
  }

  const double slow_unit_s2 =
      (d.largest_force() + d.friction) / d.total_inertia() / d.si_per_unit();
  const double expected_s = start_unit_s / slow_unit_s2;
  EXPECT_NEAR(ticks * kTick_s, expected_s, 1.5 * kTick_s);
  const double path_unit = mechanism->State(kX).motor_unit - before_unit;
  // It acts from the tick on in which it begins, evenly: the last tick alone is left.
  EXPECT_NEAR(path_unit, start_unit_s * expected_s / 2, start_unit_s * kTick_s / 20);
}

TEST_P(EitherFidelity, WhatIsInTheWayStopsTheCarriageAtTheCurrentLimit) {
  BuiltMotors motors = Built();
  motors[kX].high_obstacle_unit = 1;
  const auto mechanism = Make(motors, GetParam());
  MotorDrives drives{};
  for (int k = 0; k < 2000; ++k) {
    drives[kX] = {MotorDrive::Mode::kFollow, 0.001 * k};
    mechanism->Tick(drives);
  }

  EXPECT_NEAR(mechanism->State(kX).carriage_unit, 1, 0.01);
  EXPECT_NEAR(mechanism->State(kX).force, motors[kX].drawing.largest_force(), 1e-6);
}

// Faster at once than the energy of a cycle lifts it (76 mm/s): the rotor lets go, and
// is back at a whole number of cycles.
TEST_P(EitherFidelity, AnOverloadedStepperLosesWholeCycles) {
  BuiltMotors motors = Built();
  const auto mechanism = Make(motors, GetParam());
  MotorDrives drives{};
  double to_unit = 0;
  for (int k = 0; k < 400; ++k) {
    to_unit += 110 * kTick_s;
    drives[kU] = {MotorDrive::Mode::kFollow, to_unit};
    mechanism->Tick(drives);
  }
  for (int k = 0; k < 1200; ++k) mechanism->Tick(drives);

  const double lost_unit = to_unit - mechanism->State(kU).motor_unit;
  const double cycles = lost_unit / MagneticCycle(motors[kU].drawing);
  EXPECT_GE(cycles, 0.9);
  EXPECT_NEAR(cycles, std::round(cycles), 0.02);
}

}  // namespace
}  // namespace caltwin
