#include "sim/firmware/backlash.h"

#include <gtest/gtest.h>

#include "tests/firmware/bench.h"

namespace caltwin {
namespace {

// M425 X0.05 at 800 steps/mm.
constexpr int kGap = 40;

TEST(BacklashCompensation, AddsTheGapToAMoveThatReverses) {
  BacklashCompensation backlash;

  EXPECT_EQ(backlash.Take(1000, kGap, 10), 0);
  EXPECT_EQ(backlash.Take(-1000, kGap, 10), -kGap);
  EXPECT_EQ(backlash.Take(-1000, kGap, 10), 0);
  EXPECT_EQ(backlash.Take(1000, kGap, 10), kGap);
  EXPECT_EQ(backlash.applied_steps(), 0);
}

TEST(BacklashCompensation, ShortMovesTakeATenthOfTheirLengthEach) {
  BacklashCompensation backlash;
  backlash.Take(1000, kGap, 10);

  EXPECT_EQ(backlash.Take(-150, kGap, 10), -15);
  EXPECT_EQ(backlash.Take(-150, kGap, 10), -15);
  EXPECT_EQ(backlash.Take(-150, kGap, 10), -10);
  EXPECT_EQ(backlash.Take(-150, kGap, 10), 0);
}

TEST(BacklashCompensation, EvenOneStepTakesOne) {
  BacklashCompensation backlash;
  backlash.Take(1000, kGap, 10);

  EXPECT_EQ(backlash.Take(-1, kGap, 10), -1);
  EXPECT_EQ(backlash.due_steps(), -(kGap - 1));
}

TEST(BacklashCompensation, TurningBackTooSoonLeavesNothingBehind) {
  BacklashCompensation backlash;
  backlash.Take(1000, kGap, 10);
  backlash.Take(-100, kGap, 10);
  backlash.Take(1000, kGap, 10);

  EXPECT_EQ(backlash.applied_steps(), 0);
  EXPECT_EQ(backlash.due_steps(), 0);
}

TEST(Firmware, ReversalMovesTheMotorByTheGapMore) {
  FirmwareBench bench;
  bench.HomeAndCentre();
  bench.Say({"M425 X0.05", "G1 X120 F3000", "M400"});
  const double before = bench.firmware.motor_steps()[0];

  bench.Say({"G1 X110", "M400"});

  EXPECT_EQ(bench.firmware.motor_steps()[0] - before, -8000 - kGap);
  EXPECT_EQ(bench.firmware.position_mm()[0], 110);
  EXPECT_EQ(bench.plant.steps[0], bench.firmware.motor_steps()[0]);
}

TEST(Firmware, DistanceFactorOfM425SpreadsTheCorrection) {
  FirmwareBench bench;
  bench.HomeAndCentre();
  bench.Say({"M425 X0.05 S100", "G1 X101 F3000", "M400"});
  const double before = bench.firmware.motor_steps()[0];

  bench.Say({"G1 X100", "M400"});

  EXPECT_EQ(bench.firmware.motor_steps()[0] - before, -800 - 8);
}

TEST(Firmware, ReportedPositionLeavesBacklashStepsOut) {
  FirmwareBench bench;
  bench.HomeAndCentre();
  bench.Say({"M425 X0.05", "G1 X120 F3000", "G1 X110"});

  EXPECT_EQ(bench.Say({"M114"}).front(),
            "X:110.000 Y:100.000 Z:100.000 E:0.000 Count 88000 80000 80000 "
            "Machine 110.000 100.000 100.000");
}

TEST(Firmware, BeforeRelease361M400TookBacklashStepsForTravel) {
  FirmwareBench bench({.m400_ignores_backlash = true});
  bench.HomeAndCentre();
  bench.Say({"M425 X0.05", "G1 X120 F3000", "G1 X110"});
  const double motor_before = bench.firmware.motor_steps()[0];

  EXPECT_NEAR(bench.firmware.position_mm()[0], 100, 1e-9);  // Still queued.
  bench.Say({"M400"});

  EXPECT_DOUBLE_EQ(bench.firmware.position_mm()[0], 110 - 0.05);
  EXPECT_EQ(bench.firmware.motor_steps()[0] - motor_before, 8000 - kGap);
}

TEST(Firmware, ProbeStopCountsOnlyTheBacklashStepsAppliedByThen) {
  FirmwareBench bench;
  bench.HomeAndCentre();
  bench.Say({"M425 X0.05", "G1 X80 F3000", "G1 X70", "M400"});
  // Reversal: 40 steps are due over the 40 mm to X110. The rigid wall at 90 is met
  // where 20 mm of travel and the 20 steps applied by then add up to it, less the 40
  // steps behind since the last reversal.
  const double home = 0;
  bench.plant.wall_mm = 90;
  bench.Say({"G38.2 X110 F300"});

  const double motor = bench.firmware.motor_steps()[0] - home;
  const double count = bench.firmware.position_mm()[0] * 800;
  EXPECT_NEAR(motor, 90 * 800, 1);
  // share s of the move: 70*800 - 40 + s (40*800 + 40) = 90*800; s 40 applied steps.
  const double share = (20.0 * 800 + kGap) / (40.0 * 800 + kGap);
  EXPECT_NEAR(count, motor + kGap - share * kGap, 1);

  bench.plant.wall_mm = 1e9;
  bench.Say({"G1 X110", "M400"});  // The rest is applied by the next moves.
  EXPECT_EQ(bench.firmware.motor_steps()[0], 110 * 800);
}

TEST(Firmware, HomingClearsTheCompensation) {
  FirmwareBench bench;
  bench.HomeAndCentre();
  bench.Say({"M425 X0.05 Y0.05 Z0.05", "G28", "M400"});

  EXPECT_NEAR(bench.firmware.motor_steps()[0], 0, 1);
  bench.Say({"G1 X50 F3000", "M400"});
  EXPECT_NEAR(bench.firmware.motor_steps()[0], 50 * 800 + kGap, 1);
}

}  // namespace
}  // namespace caltwin
