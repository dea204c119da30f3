#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/kinds/delta/klipper_descent.h"
#include "sim/machine/kinds/delta/model.h"
#include "tests/calibration/delta_engine_rows.h"

namespace caltwin {
namespace {

using delta_rows::After;
using delta_rows::Believed;
using delta_rows::Built;
using testing::ElementsAre;
using testing::StrEq;

DeltaOutcome Calibrated(const DeltaBuild<double>& build) {
  SimulatedDelta machine(build, {}, 0, 1);
  return CalibrateKlipper(delta_rows::ProbeOf(&machine), Believed());
}

TEST(KlipperDescent, TouchesTheCentreAndSixScatteredPoints) {
  const auto points = KlipperProbePoints(100);

  ASSERT_EQ(points.size(), 7U);
  EXPECT_EQ(points[0].norm(), 0);
  EXPECT_NEAR(points[1][1], 95, 1e-9);
  EXPECT_NEAR(points[4][1], -70, 1e-9);
  EXPECT_NEAR(points[6].norm(), 80, 1e-9);
}

TEST(KlipperDescent, ItsPrintHasTwelveDistancesOf65Mm) {
  const auto print = KlipperPrint();

  ASSERT_EQ(print.size(), 12U);
  for (const KlipperRidge& ridge : print) {
    EXPECT_NEAR((ridge.second_mm - ridge.first_mm).norm(), 65, 1e-9);
    EXPECT_LT(ridge.second_mm.norm(), 70);
  }
}

TEST(KlipperDescent, FindsAThreeRodMachine) {
  const DeltaOutcome outcome = Calibrated(Built());

  // Its steps end below 1e-5 mm or deg all together.
  EXPECT_LT(After(outcome, Built()).z_rms_mm, 1e-5);
  EXPECT_EQ(outcome.settings.arm_mm, Believed().arm_mm);
}

TEST(KlipperDescent, LongerRodsBecomeAWrongScale) {
  const DeltaAccuracy after = After(Calibrated(Built(250.6)), Built(250.6));

  EXPECT_NEAR(UmFromMm(after.z_rms_mm), 5.1, 0.05);
  EXPECT_NEAR(1e3 * after.xy_scale, 1.9, 0.05);  // um/mm.
}

TEST(KlipperDescent, NoiseReachesTheBedAsMeasuredElsewhere) {
  const double foretold_mm = delta_rows::ForetoldRms_mm(
      Built(),
      [](const DeltaProbe& probe) { return CalibrateKlipper(probe, Believed()); });

  EXPECT_NEAR(UmFromMm(foretold_mm), 9.4, 0.1 * 9.4);
}

TEST(KlipperDescent, ItsConfigLinesHoldTheSettings) {
  const std::vector<DeltaTouch> nothing_wrong = {
      {.motors_mm = DeltaMotors_mm<double>(Believed(), {0, 0, 0})}};

  EXPECT_THAT(
      FitKlipper(nothing_wrong, {}, Believed()).messages,
      ElementsAre(StrEq("stepper_a: position_endstop: 300.000000 angle: 210.000000 "
                        "arm_length: 250.000000"),
                  StrEq("stepper_b: position_endstop: 300.000000 angle: 330.000000 "
                        "arm_length: 250.000000"),
                  StrEq("stepper_c: position_endstop: 300.000000 angle: 90.000000 "
                        "arm_length: 250.000000"),
                  StrEq("delta_radius: 130.000000")));
}

}  // namespace
}  // namespace caltwin
