#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/effects/catalog.h"
#include "sim/effects/drive.h"
#include "sim/effects/racking.h"
#include "sim/kinds/cartesian/corners.h"
#include "sim/kinds/cartesian/stepped.h"
#include "sim/kinds/triple_z/klipper.h"
#include "sim/kinds/triple_z/plant.h"
#include "sim/kinds/z_station/klipper.h"
#include "sim/machine/kinds/triple_z/drawing.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

constexpr PinSensor kProbe{.kind = PinSensor::Kind::kProbe};
constexpr double kHair_mm = 0.0005;

constexpr PinSensor Switch(int motor) {
  return {.kind = PinSensor::Kind::kSwitch, .motor = motor};
}

TEST(SteppedGantry, PlayIsOnTheSideThatItsDriveCameFrom) {
  const Machine machine = ReadMachine("models/gantry_router/machine.yaml");
  constexpr double kGap_mm = 0.05;
  Built built{
      .machine = machine,
      .effects = {
          {.effect = EffectIndex<Backlash>(), .axis = "z", .values = {kGap_mm}}}};
  built.Prepare();
  SteppedGantry gantry(built, /*is_physics=*/false, /*seed=*/1);
  const auto at = [&](double z_mm) {
    return Motors(Vec3<double>(150, 150, z_mm - machine.axis(Axis::kZ).max_mm) * 800);
  };
  // A ball of 1 mm, pushed in by its pre-travel.
  const double touch_mm =
      machine.probe.tip_radius_mm - machine.probe.pretravel_mm - kGap_mm / 2;
  const double home_mm = machine.axis(Axis::kZ).max_mm + kGap_mm / 2;

  gantry.Follow(at(50));
  gantry.Follow(at(60));

  EXPECT_FALSE(gantry.Acts(kProbe, at(touch_mm + kHair_mm)));
  EXPECT_TRUE(gantry.Acts(kProbe, at(touch_mm - kHair_mm)));
  EXPECT_FALSE(gantry.Acts(Switch(2), at(home_mm - kHair_mm)));
  EXPECT_TRUE(gantry.Acts(Switch(2), at(home_mm + kHair_mm)));
}

/// 350 mm between its motors, of which the first is 25 mm beside x = 0.
class Beam : public testing::Test {
 protected:
  Beam() {
    built_.effects = {{.effect = EffectIndex<Racking>(), .values = {kRacking_mrad}}};
    built_.Prepare();
  }
  Motors At(double x_mm, double y_mm, double y1_mm) const {
    Motors steps(4);
    steps << x_mm, y_mm, 100 - machine_.axis(Axis::kZ).max_mm, y1_mm;
    return steps * 800;
  }

  static constexpr double kRacking_mrad = 2;
  /// By so much the second switch stands further up Y: 350 mm sin(0.002).
  const double apart_mm_ = 350 * std::sin(0.002);
  Machine machine_ = ReadMachine("models/two_motor_router/machine.yaml");
  Built built_{.machine = machine_};
};

TEST_F(Beam, EachMotorHasASwitchAndTheyStandApart) {
  SteppedGantry gantry(built_, /*is_physics=*/false, /*seed=*/1);
  EXPECT_TRUE(gantry.Acts(Switch(1), At(0, 0, 50)));
  EXPECT_FALSE(gantry.Acts(Switch(1), At(0, kHair_mm, -50)));
  EXPECT_TRUE(gantry.Acts(Switch(3), At(0, 50, apart_mm_ - kHair_mm)));
  EXPECT_FALSE(gantry.Acts(Switch(3), At(0, -50, apart_mm_ + kHair_mm)));
}

// Both come down from far above, one 0.7 mm ahead of the other; a gap of 0.1 mm lags.
TEST_F(Beam, PlayShowsAtBothSwitchesAlike) {
  built_.effects.push_back(
      {.effect = EffectIndex<Backlash>(), .axis = "y", .values = {0.1}});
  built_.Prepare();
  SteppedGantry gantry(built_, /*is_physics=*/false, /*seed=*/1);
  gantry.Follow(At(0, 50, 50 + apart_mm_));
  gantry.Follow(At(0, 5, 5 + apart_mm_));
  // Coming down the carriage is half the gap above its motor.
  EXPECT_FALSE(gantry.Acts(Switch(1), At(0, -0.05 + kHair_mm, apart_mm_)));
  EXPECT_TRUE(gantry.Acts(Switch(1), At(0, -0.05 - kHair_mm, apart_mm_)));
  EXPECT_FALSE(gantry.Acts(Switch(3), At(0, 0, apart_mm_ - 0.05 + kHair_mm)));
  EXPECT_TRUE(gantry.Acts(Switch(3), At(0, 0, apart_mm_ - 0.05 - kHair_mm)));
}

TEST_F(Beam, JamsWhenItsEndsAreFarApart) {
  SteppedGantry gantry(built_, /*is_physics=*/false, /*seed=*/1);
  gantry.Follow(At(0, 100, 117));
  EXPECT_THROW(gantry.Follow(At(0, 100, 118)), Jammed);
}

TEST_F(Beam, TurnsAsItsMotorsComeApart) {
  SteppedGantry gantry(built_, /*is_physics=*/false, /*seed=*/1);
  gantry.Follow(At(150, 100, 100));
  const Vec3<double> middle_mm = gantry.Tip_mm();
  EXPECT_NEAR(middle_mm[1], 100, 1e-9);
  gantry.Follow(At(250, 100, 100.35));
  // To ask what a pin would show elsewhere turns nothing.
  gantry.Acts(kProbe, At(250, 100, 100));
  // At x = 250 the beam is 275 of 350 mm along.
  EXPECT_NEAR(gantry.Tip_mm()[1], 100 + 0.35 * 275 / 350, 1e-9);
  EXPECT_NEAR(gantry.Tip_mm()[0], 250 - 100 * (1 - std::cos(0.001)), 1e-6);
}

// What a firmware that homes each on its own switch leaves is the racking of the
// effect.
TEST_F(Beam, HomedOnItsSwitchesItIsRackedAsTheEffectSays) {
  SteppedGantry gantry(built_, /*is_physics=*/false, /*seed=*/1);
  const Vec3<double> axes =
      Vec3<double>(250, 100, 100 - machine_.axis(Axis::kZ).max_mm);
  gantry.Follow(gantry.TurnedOn(axes * 800));
  const Vec3<double> tip_mm = gantry.Tip_mm();
  gantry.Follow(gantry.TurnedOn((axes - Vec3<double>(100, 0, 0)) * 800));
  EXPECT_NEAR(tip_mm[1] - gantry.Tip_mm()[1], 100 * std::sin(0.002), 1e-9);
}

/// The height at which the probe first acts, found by halving; Z in steps of the
/// drawing.
double TouchOf_mm(SteppedPlant* plant,
                  const Machine& machine,
                  double x_mm,
                  double y_mm) {
  const auto at = [&](double z_mm) {
    return Motors(Vec3<double>(x_mm, y_mm, z_mm - machine.axis(Axis::kZ).max_mm) * 800);
  };
  double above_mm = 3, below_mm = -2;
  plant->Follow(at(above_mm + 1));
  plant->Follow(at(above_mm));
  while (above_mm - below_mm > 1e-5) {
    const double middle_mm = (above_mm + below_mm) / 2;
    (plant->Acts(kProbe, at(middle_mm)) ? below_mm : above_mm) = middle_mm;
  }
  return above_mm;
}

struct Alike {
  const char* what;
  std::vector<Injected> effects;
};

void PrintTo(const Alike& alike, std::ostream* out) {
  *out << alike.what;
}

class SteppedInMujoco : public testing::TestWithParam<Alike> {};

// Contact that bends a spring and a ball that is bent by what it would be inside are
// two models of one probe: they act at the same heights.
TEST_P(SteppedInMujoco, TouchesAndStandsAsInClosedForm) {
  const Machine machine = ReadMachine("models/gantry_router/machine.yaml");
  Built built{.machine = machine, .effects = GetParam().effects};
  built.Prepare();
  SteppedGantry closed(built, /*is_physics=*/false, /*seed=*/1);
  SteppedGantry physics(built, /*is_physics=*/true, /*seed=*/1);
  for (const Eigen::Vector2d& at_mm :
       {Eigen::Vector2d(60, 70), Eigen::Vector2d(230, 180)}) {
    EXPECT_NEAR(TouchOf_mm(&physics, machine, at_mm[0], at_mm[1]),
                TouchOf_mm(&closed, machine, at_mm[0], at_mm[1]),
                kHair_mm);
    EXPECT_LT((physics.Tip_mm() - closed.Tip_mm()).norm(), kHair_mm);
    for (SteppedGantry* const gantry : {&closed, &physics}) {
      gantry->Follow(Vec3<double>(at_mm[0], at_mm[1], -20) * 800);
    }
    EXPECT_LT((physics.Tip_mm() - closed.Tip_mm()).norm(), kHair_mm);
  }
}

INSTANTIATE_TEST_SUITE_P(
    OfAGantry,
    SteppedInMujoco,
    testing::Values(
        Alike{"drawn", {}},
        Alike{"play",
              {{.effect = EffectIndex<Backlash>(), .axis = "z", .values = {0.1}}}},
        Alike{"tilt", {{.effect = EffectIndex<BedTilt>(), .values = {2, -1}}}},
        Alike{"bowl", {{.effect = EffectIndex<BedBowl>(), .values = {80}}}},
        Alike{
            "skew",
            {{.effect = EffectIndex<Squareness>(), .axis = "B0Z", .values = {1.5}}}}));

TEST_F(Beam, StandsAskewInMujocoAsInClosedForm) {
  SteppedGantry closed(built_, /*is_physics=*/false, /*seed=*/1);
  SteppedGantry physics(built_, /*is_physics=*/true, /*seed=*/1);
  for (const double apart_mm : {0.0, 0.7, 0.0}) {
    for (SteppedGantry* const gantry : {&closed, &physics}) {
      gantry->Follow(At(250, 100, 100 + apart_mm));
    }
    EXPECT_LT((physics.Tip_mm() - closed.Tip_mm()).norm(), kHair_mm) << apart_mm;
  }
}

// What was asked in between leaves nothing behind.
TEST(SteppedInMujoco, ThePinSaysTheSameAgain) {
  const Machine machine = ReadMachine("models/gantry_router/machine.yaml");
  Built built{.machine = machine};
  built.Prepare();
  SteppedGantry gantry(built, /*is_physics=*/true, /*seed=*/1);
  const double first_mm = TouchOf_mm(&gantry, machine, 60, 70);
  TouchOf_mm(&gantry, machine, 200, 100);
  EXPECT_EQ(TouchOf_mm(&gantry, machine, 60, 70), first_mm);
}

/// Corners at (-60, -10) and (360, 370); the board counts from where it was switched
/// on.
TEST(SteppedCorners, TheGantryIsAsHighAsItsCornersBetweenThem) {
  const Machine machine = ReadMachine("models/quad_gantry_printer/machine.yaml");
  Built built{.machine = machine};
  built.Prepare();
  SteppedCorners gantry(built, /*is_physics=*/false, /*seed=*/1);
  const AxisDrawing& z = machine.axis(Axis::kZ);
  // A ball of 1 mm, pushed in by its pre-travel.
  const double touch_mm = machine.probe.tip_radius_mm - machine.probe.pretravel_mm;
  const auto at = [&](double x_mm, double y_mm, const Eigen::Vector4d& corners_mm) {
    Motors steps(6);
    steps.head<2>() << (x_mm + y_mm) * 320, (x_mm - y_mm) * 320;
    steps.tail<4>() = (corners_mm.array() - z.max_mm) * z.steps_per_mm();
    return steps;
  };
  // Over (150, 180) each corner counts a quarter; a twist counts nothing there.
  const Eigen::Vector4d twisted_mm(3, -3, 3, -3);
  const Eigen::Vector4d touching_mm = Eigen::Vector4d::Constant(touch_mm);
  for (const auto& corners_mm :
       {touching_mm, Eigen::Vector4d(touching_mm + twisted_mm)}) {
    gantry.Follow(at(150, 180, corners_mm.array() + 1));
    EXPECT_FALSE(gantry.Acts(kProbe, at(150, 180, corners_mm.array() + 2 * kHair_mm)));
    EXPECT_TRUE(gantry.Acts(kProbe, at(150, 180, corners_mm.array() - 2 * kHair_mm)));
  }
  // At (45, 85) u = v = 1/4: 9/16, 3/16, 1/16, 3/16.
  const double by_mm = 3 * (9 - 3 + 1 - 3) / 16.0;
  const Eigen::Vector4d there_mm = touching_mm + twisted_mm;
  EXPECT_FALSE(
      gantry.Acts(kProbe, at(45, 85, there_mm.array() - by_mm + 2 * kHair_mm)));
  EXPECT_TRUE(gantry.Acts(kProbe, at(45, 85, there_mm.array() - by_mm - 2 * kHair_mm)));
  EXPECT_NEAR(FlatnessOfCorners_mm(built, at(0, 0, touching_mm)), 0, 1e-9);
  EXPECT_GT(FlatnessOfCorners_mm(built, at(0, 0, there_mm)), 0.3);
}

// What the head's way does to the height is no move of a screw.
TEST(SteppedCorners, PlayIsOfTheMotorsThatMove) {
  const Machine machine = ReadMachine("models/quad_gantry_printer/machine.yaml");
  constexpr double kGap_mm = 0.1;
  Built built{
      .machine = machine,
      .effects = {
          {.effect = EffectIndex<Backlash>(), .axis = "z", .values = {kGap_mm}}}};
  built.Prepare();
  SteppedCorners gantry(built, /*is_physics=*/false, /*seed=*/1);
  const AxisDrawing& z = machine.axis(Axis::kZ);
  const Eigen::Vector4d tilted_mm(0, 3, 3, 0);
  const auto at = [&](double x_mm, double y_mm, double z_mm) {
    Motors steps(6);
    steps.head<2>() << (x_mm + y_mm) * 320, (x_mm - y_mm) * 320;
    steps.tail<4>() = (tilted_mm.array() + z_mm - z.max_mm) * z.steps_per_mm();
    return steps;
  };
  gantry.Follow(at(150, 100, 20));
  gantry.Follow(at(150, 100, 10));  // Down: the nuts are above their motors.
  gantry.Follow(at(150, 250, 10));  // Along the slope, up and down again.
  gantry.Follow(at(150, 85, 10));
  // At y = 85 the slope is at 3 * 95 / 380.
  const double touch_mm =
      machine.probe.tip_radius_mm - machine.probe.pretravel_mm - 0.75 - kGap_mm / 2;
  EXPECT_FALSE(gantry.Acts(kProbe, at(150, 85, touch_mm + 2 * kHair_mm)));
  EXPECT_TRUE(gantry.Acts(kProbe, at(150, 85, touch_mm - 2 * kHair_mm)));
}

TEST(SteppedCorners, OneOfFourMotorsHasASwitch) {
  const Machine machine = ReadMachine("models/quad_gantry_printer/machine.yaml");
  const Wiring wiring = WiringOfCorners(machine);
  ASSERT_EQ(wiring.motors.size(), 6U);
  EXPECT_EQ(wiring.motors[5].name, "Z3");
  for (const Wiring::Input& input : wiring.inputs) EXPECT_NE(input.pin, "Z1_STOP");
  EXPECT_THAT(CornersCfg(machine), testing::Not(testing::HasSubstr("endstop_pin")));
}

TEST(TwoMotorRouter, OneMotorMoreIsWired) {
  const Wiring wiring =
      WiringOfGantry(ReadMachine("models/two_motor_router/machine.yaml"));
  ASSERT_EQ(wiring.motors.size(), 4U);
  EXPECT_EQ(wiring.motors[3].name, "Y1");
  EXPECT_EQ(wiring.motors[3].start_steps, wiring.motors[1].start_steps);
}

TEST(SteppedTripleZ, EachScrewHasASwitchAndTheBedMeetsTheNozzle) {
  const Machine machine = ReadMachine("models/triple_z_printer/machine.yaml");
  TripleZTwinPlant plant({.machine = machine}, /*is_physics=*/false, 1, 0);
  const double steps_per_mm = machine.settings.steps_per_mm[2];
  const double top_mm = TripleZOf(machine).top_mm;
  const auto raised = [&](double a_mm, double b_mm, double c_mm) {
    Motors steps = Motors::Zero(5);
    steps.head<2>().setConstant(100 * machine.settings.steps_per_mm[0]);
    steps.tail<3>() = -Vec3<double>(a_mm, b_mm, c_mm) * steps_per_mm;
    return steps;
  };

  EXPECT_TRUE(plant.Acts(Switch(3), raised(1, 0, 1)));
  EXPECT_FALSE(plant.Acts(Switch(2), raised(1, 0, 1)));
  EXPECT_FALSE(plant.Acts(Switch(0), raised(1, 0, 1)));
  // Where the bed meets the nozzle and has pushed it in by the pre-travel.
  const double trigger_mm = top_mm + machine.probe.pretravel_mm;
  const double below_mm = trigger_mm - kHair_mm, above_mm = trigger_mm + kHair_mm;
  EXPECT_FALSE(plant.Acts(kProbe, raised(below_mm, below_mm, below_mm)));
  EXPECT_TRUE(plant.Acts(kProbe, raised(above_mm, above_mm, above_mm)));
}

class SteppedStations : public testing::TestWithParam<bool> {};

TEST_P(SteppedStations, SwitchAndProbeActWhereTheDrawingSays) {
  const Machine machine = ReadMachine("models/z_station/machine.yaml");
  ZStation station{.endstop_scatter_mm = 0, .probe_scatter_mm = 0};
  SteppedStation head(machine, station, /*is_physics=*/GetParam(), /*seed=*/1);
  const auto at = [&](double x_mm, double y_mm, double z_mm) {
    return Motors(Vec3<double>(x_mm * 80, y_mm * 80, z_mm * 3200));
  };
  constexpr double kAgree_mm = 0.002;

  // The nozzle over the switch at (120, 230), then the body, 25 mm behind it.
  EXPECT_FALSE(head.Acts(Switch(2), at(120, 230, 1.5 + kAgree_mm)));
  EXPECT_TRUE(head.Acts(Switch(2), at(120, 230, 1.5 - kAgree_mm)));
  EXPECT_FALSE(head.Acts(Switch(2), at(120, 205, 8 + kAgree_mm)));
  EXPECT_TRUE(head.Acts(Switch(2), at(120, 205, 8 - kAgree_mm)));
  EXPECT_FALSE(head.Acts(Switch(2), at(60, 60, 0.5)));
  EXPECT_FALSE(head.Acts(kProbe, at(117.5, 92.5, 7 + kAgree_mm)));
  EXPECT_TRUE(head.Acts(kProbe, at(117.5, 92.5, 7 - kAgree_mm)));
}

INSTANTIATE_TEST_SUITE_P(FastAndPhysics, SteppedStations, testing::Bool());

}  // namespace
}  // namespace caltwin
