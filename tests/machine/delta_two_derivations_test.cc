// The six-rod chain against that of the blind tests' truth, derived and solved apart
// from it.

#include <gtest/gtest.h>

#include "sim/machine/kinds/delta/model.h"
#include "tests/blind/delta/parts.h"

namespace caltwin {
namespace {

blind::DeltaPaper Paper() {
  return {.radius_mm = 130,
          .arm_mm = 250,
          .endstop_mm = 300,
          .rod_spacing_mm = 45,
          .effector_radius_mm = 35,
          .joint_height_mm = 20};
}

DeltaBuild<double> Drawn() {
  return {.model = SymmetricDelta(300, 130, 250),
          .rod_spacing_mm = 45,
          .effector_radius_mm = 35,
          .joint_height_mm = 20};
}

void ExpectSame(const blind::DeltaMade& made,
                const DeltaBuild<double>& build,
                double tolerance_mm) {
  for (const Vec3<double>& sent :
       {Vec3<double>(0, 0, 5), Vec3<double>(80, 0, 5), Vec3<double>(-60, -40, 90)}) {
    const Vec3<double> travel_mm = blind::TravelFor(Paper(), sent);
    const auto theirs = blind::NozzleAt(Paper(), made, travel_mm);
    const auto ours = DeltaPoseOf(build, travel_mm);
    ASSERT_TRUE(theirs && ours);
    EXPECT_LT((*theirs - ours->nozzle_mm).norm(), tolerance_mm);
  }
}

TEST(DeltaTwoDerivations, AgreeOnTheMachineAsDrawn) {
  ExpectSame({}, Drawn(), 1e-8);
}

TEST(DeltaTwoDerivations, AgreeOnRodsTwistAndBelts) {
  blind::DeltaMade made;
  DeltaBuild<double> build = Drawn();
  made.rod_mm[1] = build.rod_error_mm[1] = 0.2;
  made.rod_mm[4] = build.rod_error_mm[4] = -0.1;
  made.twist[2] = build.twist_rad[2] = 0.01;
  made.belt[0] = build.belt_scale[0] = 1e-3;
  ExpectSame(made, build, 1e-8);
}

// The effector's joints stay as drawn here, and go round with the angle of three-rod
// formulas there: nothing while the rods of each tower are alike.
TEST(DeltaTwoDerivations, AgreeOnATowerThatStandsRound) {
  blind::DeltaMade made;
  DeltaBuild<double> build = Drawn();
  made.angle[0] = 2e-3;
  build.twist_per_angle = TwistPerAngle(build.model, build.effector_radius_mm);
  StandRound(0, 2e-3, &build);
  ExpectSame(made, build, 1e-3);
  // A hundred times less than what the angle does.
  DeltaBuild<double> firmware = Drawn();
  firmware.model.angle_rad[0] += 2e-3;
  const Vec3<double> sent(80, 0, 5);
  const auto theirs = blind::NozzleAt(Paper(), made, blind::TravelFor(Paper(), sent));
  const auto as_firmware = DeltaPoseOf(firmware, blind::TravelFor(Paper(), sent));
  ASSERT_TRUE(theirs && as_firmware);
  EXPECT_GT((*theirs - as_firmware->nozzle_mm).norm(), 1e-2);
}

// The truth code leans by slopes, this one along a unit vector: a second-order
// difference of h lean^2 / 2, a micrometre at 2 mrad and 500 mm.
TEST(DeltaTwoDerivations, AgreeOnLeaningTowers) {
  blind::DeltaMade made;
  DeltaBuild<double> build = Drawn();
  made.lean_out[0] = build.lean_radial_rad[0] = 2e-3;
  made.lean_round[1] = build.lean_tangential_rad[1] = -2e-3;
  ExpectSame(made, build, 3e-3);
}

}  // namespace
}  // namespace caltwin
