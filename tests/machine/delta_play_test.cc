#include <gtest/gtest.h>

#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/kinds/delta/play.h"
#include "sim/machine/kinds/kinds.h"

namespace caltwin {
namespace {

const Vec3<double> kDown(1, 1, 1), kUp(-1, -1, -1);

Machine Delta(double rail_friction_n) {
  Machine machine{.kind = DeltaKind(), .own = DeltaDrawing{}};
  for (AxisDrawing& tower : machine.axes) {
    tower.moving_mass_kg = 0.15;
    tower.rail_friction_n = rail_friction_n;
  }
  return machine;
}

// Where the nozzle stands over the commanded place, its carriages loose by these gaps.
Vec3<double> Off_mm(const Machine& machine,
                    const CarriageGaps_mm& gaps_mm,
                    const Vec3<double>& at_mm,
                    const Vec3<double>& motor_dir) {
  const DeltaBuild<double> build = DeltaOf(machine).Build();
  const Vec3<double> motors_mm = DeltaMotors_mm(build.model, at_mm);
  const auto taken = WithPlayTaken(build, machine, gaps_mm, motors_mm, motor_dir);
  return DeltaPoseOf(*taken, motors_mm)->nozzle_mm - at_mm;
}

// All three alike, the middle of the bed: the nozzle goes as the carriages do.
TEST(DeltaPlay, AfterMovesDownANozzleStandsHalfTheGapTooHigh) {
  constexpr double kRounding_mm = 1e-9;
  const Machine held = Delta(6);
  const CarriageGaps_mm gaps_mm = {0.06, 0.06, 0.06};
  const Vec3<double> middle_mm(0, 0, 10);

  EXPECT_NEAR(Off_mm(held, gaps_mm, middle_mm, kDown)[2], 0.03, kRounding_mm);
  EXPECT_NEAR(Off_mm(held, gaps_mm, middle_mm, kUp)[2], -0.03, kRounding_mm);
  EXPECT_NEAR(
      Off_mm(held, gaps_mm, middle_mm, Vec3<double>::Zero()).norm(), 0, kRounding_mm);
}

TEST(DeltaPlay, ACarriageThatHangsLosesNothingAtAReversal) {
  const Machine hangs = Delta(0.5);
  const CarriageGaps_mm gaps_mm = {0, 0, 0.06};

  for (const Vec3<double>& at_mm : {Vec3<double>(0, 0, 0), {50, -30, 20}, {0, 80, 5}}) {
    const Vec3<double> down_mm = Off_mm(hangs, gaps_mm, at_mm, kDown);
    EXPECT_EQ(down_mm, Off_mm(hangs, gaps_mm, at_mm, kUp));
    EXPECT_LT(down_mm[2], -0.001);
  }
}

// The effector's share is largest at the tower itself, so a rail that is in between
// holds the carriage far from it and not near by.
TEST(DeltaPlay, TheSameRailHoldsFarFromTheTowerAndNotNearIt) {
  const Machine between = Delta(2.75);
  const CarriageGaps_mm gaps_mm = {0, 0, 0.06};
  const auto lost_mm = [&](double y_mm) {
    const Vec3<double> at_mm(0, y_mm, 0);
    return Off_mm(between, gaps_mm, at_mm, kDown)[2] -
           Off_mm(between, gaps_mm, at_mm, kUp)[2];
  };

  EXPECT_EQ(lost_mm(80), 0);
  EXPECT_GT(lost_mm(-20), 0.005);
}

TEST(DeltaPlay, WithoutGapsItIsTheSameBuild) {
  const Machine machine = Delta(6);
  const DeltaBuild<double> build = DeltaOf(machine).Build();

  const auto taken =
      WithPlayTaken(build, machine, {}, DeltaMotors_mm(build.model, {0, 0, 0}), kDown);

  EXPECT_EQ(taken->model.endstop_mm, build.model.endstop_mm);
}

}  // namespace
}  // namespace caltwin
