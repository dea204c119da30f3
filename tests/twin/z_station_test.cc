// Where a nozzle's height is calibrated: MuJoCo against the closed form.

#include <array>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "sim/kinds/z_station/station.h"

namespace caltwin {
namespace {

constexpr double kMust_mm = 1e-4;

ZStation Quiet() {
  return {.endstop_scatter_mm = 0, .probe_scatter_mm = 0};
}

struct StationCase {
  const char* what;
  ZStation station;
  bool is_hot = false;
};

std::vector<StationCase> StationCases() {
  std::vector<StationCase> cases(7);
  for (StationCase& one : cases) one.station = Quiet();
  cases[0].what = "as drawn";
  cases[1].what = "another nozzle, with ooze";
  cases[1].station.nozzle_mm = 0.35;
  cases[1].station.ooze_mm = 0.12;
  cases[2].what = "a thick plate";
  cases[2].station.plate_mm = 6;
  cases[3].what = "a knob that hangs far out";
  cases[3].station.trigger_mm = 1.2;
  cases[4].what = "hot";
  cases[4].is_hot = true;
  cases[5].what = "a bed that leans and is a bowl";
  cases[5].station.bed_slope_x_mrad = 5;
  cases[5].station.bed_slope_y_mrad = -3;
  cases[5].station.bed_bowl_mm = 0.3;
  cases[6].what = "a switch below the bed";
  cases[6].station.switch_mm = -4;
  return cases;
}

TEST(ZStationTwin, TriggersInPhysicsWhereTheClosedFormSays) {
  for (const StationCase& one : StationCases()) {
    SCOPED_TRACE(one.what);
    ZStationTwin fast(one.station, /*is_physics=*/false, 1, 0);
    ZStationTwin physics(one.station, /*is_physics=*/true, 1, 0);
    if (one.is_hot) {
      for (ZStationTwin* twin : {&fast, &physics}) {
        twin->Heat('n', 240);
        twin->Heat('b', 100);
        twin->Heat('c', 60);
      }
    }
    const Eigen::Vector2d at_mm(180, 60);
    for (const ZTouch touch :
         {ZTouch::kNozzleOnSwitch, ZTouch::kBodyOnSwitch, ZTouch::kProbeOnBed}) {
      const auto expected_mm = fast.Touch(touch, at_mm);
      const auto found_mm = physics.Touch(touch, at_mm);
      ASSERT_TRUE(expected_mm && found_mm);
      EXPECT_NEAR(*found_mm, *expected_mm, kMust_mm);
    }
  }
}

// Heights by hand: growth of frame, nozzle and bed cancel where they are shared.
TEST(ZStationTwin, GrowsAsItsPartsDo) {
  ZStationTwin twin(Quiet(), /*is_physics=*/false, 1, 0);
  const Eigen::Vector2d middle_mm = twin.middle_mm();
  twin.Heat('n', 220);
  twin.Heat('b', 100);
  twin.Heat('c', 60);

  // Frame 40 K x 2 um up, nozzle 200 K x 0.2 um down, bed 80 K x 0.5 um up.
  EXPECT_NEAR(*twin.Touch(ZTouch::kNozzleOnSwitch, middle_mm), 1.5, 1e-12);
  EXPECT_NEAR(*twin.Touch(ZTouch::kBodyOnSwitch, middle_mm), 8 - 0.04, 1e-12);
  EXPECT_NEAR(*twin.Touch(ZTouch::kProbeOnBed, middle_mm), 7 - 0.04, 1e-12);
  EXPECT_NEAR(twin.Gap_mm(0, middle_mm), 0, 1e-12);
}

// The nozzle meets the switch instead, and over the bed nothing triggers.
TEST(ZStationTwin, AProbeLeftInItsDockTouchesNothing) {
  ZStation station = Quiet();
  station.dock_misses = 1;
  for (const bool is_physics : {false, true}) {
    ZStationTwin twin(station, is_physics, 1, 0);
    EXPECT_NEAR(*twin.Touch(ZTouch::kBodyOnSwitch, twin.middle_mm()), 1.5, kMust_mm);
    EXPECT_FALSE(twin.Touch(ZTouch::kProbeOnBed, twin.middle_mm()).has_value());
  }
}

}  // namespace
}  // namespace caltwin
