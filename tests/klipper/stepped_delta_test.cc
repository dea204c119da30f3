#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/kinds/delta/klipper.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/delta/touch.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

constexpr PinSensor kProbe{.kind = PinSensor::Kind::kProbe};

Machine DeltaPrinter() {
  return ReadMachine("models/delta_printer/machine.yaml");
}

/// With a tower too far out, a carriage too low and a bed that leans.
BuiltDelta Wrong(const Machine& machine) {
  BuiltDelta built{.build = DeltaOf(machine).Build()};
  built.build.model.radius_mm[0] += 0.5;
  built.build.model.endstop_mm[1] -= 0.3;
  built.bed.slope_x = 0.002;
  return built;
}

class SteppedDeltas : public testing::TestWithParam<bool> {};

TEST_P(SteppedDeltas, TheProbeActsWhereTheClosedFormTouches) {
  const Machine machine = DeltaPrinter();
  const BuiltDelta built = Wrong(machine);
  SteppedDelta delta(machine, built, /*is_physics=*/GetParam(), /*seed=*/1);
  const DeltaModel<double>& believed = DeltaOf(machine).settings;
  const double steps_per_mm = TowerStepsPerMm(machine)[0];
  constexpr double kAgree_mm = 0.0005;  // Physics and closed form: 0.02 um.

  for (const auto& [x_mm, y_mm] : {std::pair{0.0, 0.0}, {60.0, -20.0}, {-40.0, 50.0}}) {
    const auto touch_mm =
        DeltaTouchMotors(built.build, built.bed, believed, x_mm, y_mm);
    ASSERT_TRUE(touch_mm);
    const Motors above = (touch_mm->array() - kAgree_mm) * steps_per_mm;
    const Motors below = (touch_mm->array() + kAgree_mm) * steps_per_mm;
    EXPECT_FALSE(delta.Acts(kProbe, above));
    EXPECT_TRUE(delta.Acts(kProbe, below));
    EXPECT_FALSE(delta.Acts(kProbe, Motors(above.array() - 50 * steps_per_mm)));
    EXPECT_TRUE(delta.Acts(kProbe, Motors(above.array() + 3 * steps_per_mm)));
  }
}

INSTANTIATE_TEST_SUITE_P(FastAndPhysics, SteppedDeltas, testing::Bool());

TEST(SteppedDelta, ScatterIsDrawnAnewForEachWatch) {
  const Machine machine = DeltaPrinter();
  BuiltDelta built{.build = DeltaOf(machine).Build()};
  built.scatter_mm = 0.01;
  SteppedDelta delta(machine, built, /*is_physics=*/false, /*seed=*/1);
  const auto touch_mm =
      DeltaTouchMotors(built.build, built.bed, DeltaOf(machine).settings, 0, 0);
  const Motors at = *touch_mm * TowerStepsPerMm(machine)[0];

  int early = 0;
  constexpr int kWatches = 200;
  for (int i = 0; i < kWatches; ++i) {
    delta.Arm(kProbe);
    if (delta.Acts(kProbe, at)) ++early;
    EXPECT_EQ(delta.Acts(kProbe, at), delta.Acts(kProbe, at));
  }

  // Half of them, to four standard deviations of a coin: 4 sqrt(200) / 2.
  EXPECT_NEAR(early, 0.5 * kWatches, 28);
}

TEST(SteppedDelta, IsWiredWithItsCarriagesBelowTheirEndstops) {
  const Machine machine = DeltaPrinter();
  PlantBoard board(
      WiringOfDelta(machine),
      std::make_unique<SteppedDelta>(
          machine, BuiltDelta{.build = DeltaOf(machine).Build()}, false, 1));
  const auto pins = board.pins();
  ASSERT_EQ(pins[6], "A_STOP");
  ASSERT_EQ(pins[4], "C_STEP");
  EXPECT_THAT(board.MotorAt(4), testing::Optional(2));
  EXPECT_EQ(board.MotorAt(5), std::nullopt);
  const double steps = 21.3 * TowerStepsPerMm(machine)[0];

  Motors at = Motors::Zero(3);
  EXPECT_FALSE(board.IsHigh(6, at));
  at[0] = steps - 1;  // Klipper counts up towards the endstop.
  EXPECT_FALSE(board.IsHigh(6, at));
  at[0] = steps;
  EXPECT_TRUE(board.IsHigh(6, at));
  EXPECT_FALSE(board.IsHigh(7, at));
}

TEST(SteppedDelta, ItsPrinterCfgSaysWhatItsFirmwareBelieves) {
  Machine machine = DeltaPrinter();
  DeltaOf(machine).settings.endstop_mm[1] = 299.5;
  const std::string text = PrinterCfgOfDelta(machine, "/tmp/somewhere");
  EXPECT_THAT(text,
              testing::AllOf(testing::HasSubstr("serial: /tmp/somewhere\n"),
                             testing::HasSubstr("kinematics: delta\n"),
                             testing::HasSubstr("delta_radius: 130\n"),
                             testing::HasSubstr("position_endstop: 299.5\n"),
                             testing::HasSubstr("angle: 210\n"),
                             testing::HasSubstr("rotation_distance: 40\n"),
                             testing::HasSubstr("endstop_pin: B_STOP\n")));
}

}  // namespace
}  // namespace caltwin
