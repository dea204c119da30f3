#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/kinds/delta/touch.h"

namespace caltwin {
namespace {

constexpr double kRad = std::numbers::pi / 180;

// The machine on which public engines were compared: the drawing, and as it is built.
DeltaModel<double> Believed() {
  return SymmetricDelta(300, 130, 250);
}
DeltaBuild<double> Built() {
  DeltaBuild<double> build{.model = SymmetricDelta(300, 130.8, 250)};
  build.model.angle_rad[0] += 0.35 * kRad;
  build.model.angle_rad[1] -= 0.25 * kRad;
  build.model.endstop_mm = {300.30, 299.80, 300.45};
  return build;
}

TEST(DeltaTouch, ItsMotorsPutTheTrueNozzleOnTheBed) {
  const DeltaBed<double> bed{.height_mm = 0.3,
                             .slope_x = 0.002,
                             .slope_y = -0.001,
                             .bowl_mm = 0.1,
                             .twist_mm = 0.05};
  for (const double x : {-80.0, 0.0, 60.0}) {
    const auto motors = DeltaTouchMotors(Built(), bed, Believed(), x, 30);
    ASSERT_TRUE(motors);
    const Vec3<double> nozzle = DeltaPoseOf(Built(), *motors)->nozzle_mm;
    EXPECT_NEAR(nozzle[2], bed.Height_mm(nozzle[0], nozzle[1]), 1e-9);
    // The firmware believes to be straight above its target.
    const Vec3<double> believed = DeltaNozzle_mm(Believed(), *motors);
    EXPECT_NEAR(believed[0], x, 1e-9);
    EXPECT_NEAR(believed[1], 30, 1e-9);
  }
}

TEST(DeltaTouch, BeyondItsReachThereIsNoTouch) {
  EXPECT_FALSE(DeltaTouchMotors(Built(), {}, Believed(), 400, 0));
}

TEST(DeltaTouch, BedShapesRaiseTheRimByTheirHeight) {
  const DeltaBed<double> bowl{.bowl_mm = 0.2}, twist{.twist_mm = 0.1};

  EXPECT_DOUBLE_EQ(bowl.Height_mm(60, 80), 0.2);
  EXPECT_DOUBLE_EQ(bowl.Height_mm(0, 0), 0);
  EXPECT_DOUBLE_EQ(twist.Height_mm(100 / std::sqrt(2.0), 100 / std::sqrt(2.0)), 0.1);
}

// Measured with the public engines' own code before any of them calibrated.
TEST(DeltaTouch, TheUncalibratedMachineErrsAsMeasuredElsewhere) {
  const DeltaAccuracy plain = DeltaAccuracyOf(Built(), {}, Believed(), 100);
  const DeltaAccuracy tilted =
      DeltaAccuracyOf(Built(), {.slope_x = 0.002, .slope_y = -0.001}, Believed(), 100);
  DeltaBuild<double> longer = Built();
  longer.model.arm_mm.fill(250.6);

  EXPECT_NEAR(plain.z_rms_mm, 0.246, 5e-4);
  EXPECT_NEAR(tilted.z_rms_mm, 0.339, 5e-4);
  EXPECT_NEAR(plain.xy_scale, -7.6e-3, 5e-5);
}

}  // namespace
}  // namespace caltwin
