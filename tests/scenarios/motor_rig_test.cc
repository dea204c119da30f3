// What a motor stage's terminals show.

#include <gtest/gtest.h>

#include "tests/scenarios/motor_bench.h"

namespace caltwin {
namespace {

// Pulses begin at the encoder's edges, wherever between two of them the axis stood at
// power-up; what it counts from there are whole edges passed.
TEST(MotorStageRig, CountsTheEdgesItPasses) {
  for (const double part : {0.0, 0.4}) {
    BuiltMotorStage built = BuiltAsDrawn(DrawnMotorStage());
    built.faults[0].pulse_part = part;
    MotorStageRig rig(built, /*is_physics=*/false, 1, 0);
    const double pulse_mm = 1 / built.drawing.axes[0].pulses_per_unit();
    const auto count_after = [&](double pulses) {
      rig.MoveByHand(0, built.faults[0].start_unit + pulses * pulse_mm);
      return rig.Count(0);
    };

    EXPECT_EQ(count_after(0.3), 0);
    EXPECT_EQ(count_after(0.9 - part), 0);
    EXPECT_EQ(count_after(1.1 - part), 1);
    EXPECT_EQ(count_after(-0.1 - part), -1);
    EXPECT_EQ(count_after(7.5 - part), 7);
  }
}

}  // namespace
}  // namespace caltwin
