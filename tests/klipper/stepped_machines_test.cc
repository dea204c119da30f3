#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/effects/catalog.h"
#include "sim/effects/drive.h"
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
  SteppedGantry gantry(built, /*seed=*/1);
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
