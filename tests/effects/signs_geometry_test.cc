// Signs of the geometric, probe, artefact and servo effects, by hand from CONTRACT's
// words: + as the error moves the tool, rotations right-handed about their letter.
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "sim/effects/angular.h"
#include "sim/effects/axis_twist.h"
#include "sim/effects/bed_bowl.h"
#include "sim/effects/bed_cylinder.h"
#include "sim/effects/bed_tilt.h"
#include "sim/effects/bed_twist.h"
#include "sim/effects/block_rotated.h"
#include "sim/effects/block_size.h"
#include "sim/effects/gantry_sag.h"
#include "sim/effects/probe_lobing.h"
#include "sim/effects/servo_lag.h"
#include "sim/effects/servo_mismatch.h"
#include "sim/effects/straightness.h"
#include "sim/effects/stylus_anisotropy.h"
#include "sim/effects/tip_runout.h"

namespace caltwin {
namespace {

constexpr double kExact = 1e-12;
const Vec3<double> kUp(0, 0, 1);

// 300 x 300 x 120 mm of travel: the middle is (150, 150, 60).
Machine Gantry() {
  Machine machine{.name = "test"};
  machine.axes[2].max_mm = 120;
  return machine;
}

template <typename Effect>
Errors<double> ErrorsOf(const At& at,
                        std::string_view axis,
                        const std::vector<double>& values) {
  const Machine machine = Gantry();
  Errors<double> errors;
  Effect::template Add<double>(
      {.p = values, .axis = axis, .machine = machine, .at = at, .q_mm = at.q_mm},
      &errors);
  return errors;
}

template <typename Effect>
Vec3<double> Motion_mm(const Vec3<double>& q_mm,
                       std::string_view axis,
                       const std::vector<double>& values,
                       const Vec3<double>& probe_off_mm = Vec3<double>::Zero()) {
  const At at{.q_mm = q_mm, .probe_off_mm = probe_off_mm};
  return ErrorsOf<Effect>(at, axis, values).motion_mm;
}

void ExpectNear(const Vec3<double>& actual,
                const Vec3<double>& expected,
                double neglected_mm = kExact) {
  EXPECT_LE((actual - expected).cwiseAbs().maxCoeff(), neglected_mm)
      << actual.transpose() << " is not " << expected.transpose();
}

TEST(SignsOfGeometry, APositiveBowHasBothEndsToPlusOfItsMiddleByItsHeight) {
  for (const std::string_view axis : Straightness::kAxes) {
    const int moving = axis[2] - 'X';
    Vec3<double> low(150, 150, 60);
    Vec3<double> high = low;
    low[moving] = 0;
    high[moving] = 2 * high[moving];
    const Vec3<double> middle_mm = Motion_mm<Straightness>({150, 150, 60}, axis, {30});

    const Vec3<double> low_mm = Motion_mm<Straightness>(low, axis, {30}) - middle_mm;
    const Vec3<double> high_mm = Motion_mm<Straightness>(high, axis, {30}) - middle_mm;

    const Vec3<double> expected_mm = 0.030 * Vec3<double>::Unit(axis[1] - 'X');
    ExpectNear(low_mm, expected_mm);
    ExpectNear(high_mm, expected_mm);
  }
}

TEST(SignsOfGeometry, APositiveSagHangsLowestInTheMiddleOfX) {
  const double ends_mm = Motion_mm<GantrySag>({300, 20, 30}, "", {60})[2];
  const double middle_mm = Motion_mm<GantrySag>({150, 20, 30}, "", {60})[2];

  EXPECT_NEAR(ends_mm, +0.040, kExact);
  EXPECT_NEAR(middle_mm, -0.020, kExact);
}

TEST(SignsOfGeometry, ATwistLiftsAProbeInFrontAtTheFarEndAndLowersItAtTheNear) {
  const Vec3<double> in_front(0, 40, 0);

  // +0.5 mrad about x at x = 300, z in its middle: dz = theta off_y.
  ExpectNear(Motion_mm<AxisTwist>({300, 0, 60}, "", {1}, in_front),
             {0, 0, +40 * 0.0005},
             40 * 0.0005 * 0.0005);
  ExpectNear(Motion_mm<AxisTwist>({0, 0, 60}, "", {1}, in_front),
             {0, 0, -40 * 0.0005},
             40 * 0.0005 * 0.0005);
  // Above the middle the tip goes back: dy = -theta (z - z_mid).
  ExpectNear(Motion_mm<AxisTwist>({300, 0, 100}, "", {1}),
             {0, -40 * 0.0005, 0},
             40 * 0.0005 * 0.0005);
}

TEST(SignsOfGeometry, RotationsOfTheXCarriageAreRightHandedAboutTheirLetter) {
  const double neglected_mm = 50 * 1e-4 * 1e-4;

  // +100 urad at x = 300. B: x follows z; C: x goes against y, y follows x.
  ExpectNear(Motion_mm<Angular>({300, 0, 110}, "EBX", {200}),
             {+50 * 1e-4, 0, 0},
             neglected_mm);
  ExpectNear(Motion_mm<Angular>({300, 0, 60}, "ECX", {200}, {0, 40, 0}),
             {-40 * 1e-4, 0, 0},
             neglected_mm);
  ExpectNear(Motion_mm<Angular>({300, 0, 60}, "ECX", {200}, {40, 0, 0}),
             {0, +40 * 1e-4, 0},
             neglected_mm);
  ExpectNear(
      Motion_mm<Angular>({0, 0, 110}, "EBX", {200}), {-50 * 1e-4, 0, 0}, neglected_mm);
}

TEST(SignsOfGeometry, RotationsOfTheYCarriageReachAlongTheBeamItCarries) {
  const double neglected_mm = 150 * 1e-4 * 1e-4;

  // +100 urad at y = 300, the head 100 mm to + of mid x and 50 mm above mid z.
  ExpectNear(Motion_mm<Angular>({250, 300, 110}, "EAY", {200}),
             {0, -50 * 1e-4, 0},
             neglected_mm);
  ExpectNear(Motion_mm<Angular>({250, 300, 110}, "EBY", {200}),
             {+50 * 1e-4, 0, -100 * 1e-4},
             neglected_mm);
  ExpectNear(Motion_mm<Angular>({250, 300, 110}, "ECY", {200}),
             {0, +100 * 1e-4, 0},
             neglected_mm);
}

TEST(SignsOfGeometry, RotationsOfTheZSlideReachTheProbesOffsetOnly) {
  const double neglected_mm = 40 * 1e-4 * 1e-4;

  for (const std::string_view axis : {"EAZ", "EBZ", "ECZ"}) {
    ExpectNear(Motion_mm<Angular>({250, 300, 120}, axis, {200}), {0, 0, 0});
  }
  // +100 urad at z = 120.
  ExpectNear(Motion_mm<Angular>({250, 300, 120}, "EAZ", {200}, {0, 40, 0}),
             {0, 0, +40 * 1e-4},
             neglected_mm);
  ExpectNear(Motion_mm<Angular>({250, 300, 120}, "EBZ", {200}, {40, 0, 0}),
             {0, 0, -40 * 1e-4},
             neglected_mm);
  ExpectNear(Motion_mm<Angular>({250, 300, 120}, "ECZ", {200}, {40, 0, 0}),
             {0, +40 * 1e-4, 0},
             neglected_mm);
}

// Height of the table where the tip stands, from a touch straight down.
template <typename Shape>
double Height_mm(const Vec3<double>& q_mm, std::string_view axis, double turn_deg = 0) {
  const At at{.q_mm = q_mm, .n = kUp, .on_table = true, .artefact_turn_deg = turn_deg};
  return ErrorsOf<Shape>(at, axis, {100}).artefact_mm;
}

TEST(SignsOfGeometry, APositiveBedShapeRaisesCornersEdgesAndTwoOppositeCorners) {
  EXPECT_NEAR(Height_mm<BedBowl>({150, 150, 0}, ""), 0, kExact);
  EXPECT_NEAR(Height_mm<BedBowl>({300, 0, 0}, ""), +0.1, kExact);
  EXPECT_NEAR(Height_mm<BedBowl>({300, 150, 0}, ""), +0.05, kExact);
  EXPECT_NEAR(Height_mm<BedCylinder>({0, 200, 0}, "x"), +0.1, kExact);
  EXPECT_NEAR(Height_mm<BedCylinder>({150, 300, 0}, "x"), 0, kExact);
  EXPECT_NEAR(Height_mm<BedCylinder>({150, 300, 0}, "y"), +0.1, kExact);
  EXPECT_NEAR(Height_mm<BedTwist>({300, 300, 0}, ""), +0.1, kExact);
  EXPECT_NEAR(Height_mm<BedTwist>({0, 0, 0}, ""), +0.1, kExact);
  EXPECT_NEAR(Height_mm<BedTwist>({300, 0, 0}, ""), -0.1, kExact);
}

TEST(SignsOfGeometry, APlateTurnedCounterClockwiseTakesItsShapeAlong) {
  // The plate's +x edge then lies at +y.
  EXPECT_NEAR(Height_mm<BedCylinder>({150, 300, 0}, "x", 90), +0.1, kExact);
  EXPECT_NEAR(Height_mm<BedCylinder>({300, 150, 0}, "x", 90), 0, kExact);
  EXPECT_NEAR(Height_mm<BedTwist>({300, 300, 0}, "", 90), -0.1, kExact);
  // Of 45 degrees: the point at +x is at u = cos 45, v = -sin 45.
  EXPECT_NEAR(Height_mm<BedTwist>({300, 150, 0}, "", 45), -0.05, kExact);
}

TEST(SignsOfGeometry, ABedShapeIsNotFeltByWhatDoesNotStandOnTheTable) {
  const At at{.q_mm = {300, 300, 0}, .n = kUp, .on_table = false};

  EXPECT_EQ(ErrorsOf<BedBowl>(at, "", {100}).artefact_mm, 0);
}

TEST(SignsOfGeometry, ATiltedTableIsFeltWhereTheTipIsNotWhereTheAxesStand) {
  const At at{
      .q_mm = {150, 150, 0}, .n = kUp, .on_table = true, .probe_off_mm = {0, 40, 0}};

  EXPECT_NEAR(ErrorsOf<BedTilt>(at, "", {0, 1}).artefact_mm, 0.040, kExact);
}

// A touch of the face that looks in that direction.
double MorePretravel_mm(double theta_deg, double spindle_deg, bool three) {
  const double theta_rad = RadFromDeg(theta_deg);
  const At at{.n = {std::cos(theta_rad), std::sin(theta_rad), 0},
              .probe_angle_deg = spindle_deg};
  return three ? ErrorsOf<ProbeLobing>(at, "", {5, 0}).more_pretravel_mm
               : ErrorsOf<StylusAnisotropy>(at, "", {5, 0}).more_pretravel_mm;
}

TEST(SignsOfGeometry, LobesAddPretravelWhereTheirPhaseIsZeroAndTurnWithTheSpindle) {
  EXPECT_NEAR(MorePretravel_mm(0, 0, true), +0.005, kExact);
  EXPECT_NEAR(MorePretravel_mm(120, 0, true), +0.005, kExact);
  EXPECT_NEAR(MorePretravel_mm(180, 0, true), -0.005, kExact);
  EXPECT_NEAR(MorePretravel_mm(30, 30, true), +0.005, kExact);
  EXPECT_NEAR(MorePretravel_mm(180, 0, false), +0.005, kExact);
  EXPECT_NEAR(MorePretravel_mm(90, 0, false), -0.005, kExact);
  EXPECT_NEAR(MorePretravel_mm(90, 90, false), +0.005, kExact);
}

TEST(SignsOfGeometry, APositivePhaseTurnsTheLobesClockwise) {
  const At at{.n = {1, 0, 0}};

  // cos(3 * 0 + 60 deg)
  EXPECT_NEAR(ErrorsOf<ProbeLobing>(at, "", {5, 60}).more_pretravel_mm, 0.0025, kExact);
}

TEST(SignsOfGeometry, ATouchStraightDownFeelsNoLobes) {
  const At at{.n = kUp};

  EXPECT_EQ(ErrorsOf<ProbeLobing>(at, "", {5, 0}).more_pretravel_mm, 0);
  EXPECT_EQ(ErrorsOf<StylusAnisotropy>(at, "", {5, 0}).more_pretravel_mm, 0);
}

TEST(SignsOfGeometry, ATipThatRunsOutStandsAtItsPhasePlusTheSpindlesAngle) {
  const At still{};
  const At turned{.probe_angle_deg = 90};
  const At gauge{.kind = RowKind::kPosition};

  ExpectNear(ErrorsOf<TipRunout>(still, "", {20, 0}).motion_mm, {0.020, 0, 0});
  ExpectNear(ErrorsOf<TipRunout>(still, "", {20, 90}).motion_mm, {0, 0.020, 0});
  ExpectNear(ErrorsOf<TipRunout>(turned, "", {20, 90}).motion_mm, {-0.020, 0, 0});
  ExpectNear(ErrorsOf<TipRunout>(gauge, "", {20, 0}).motion_mm, {0, 0, 0});
}

// Radial error of a circle of 50 mm radius run at 20 mm/s in that sense.
template <typename Effect>
double Radial_mm(double theta_deg, double sense, double value) {
  const double theta_rad = RadFromDeg(theta_deg);
  const Vec3<double> n(std::cos(theta_rad), std::sin(theta_rad), 0);
  const At at{.kind = RowKind::kRadial,
              .dir = {n[1] > 0 ? -sense : sense, n[0] > 0 ? sense : -sense, 0},
              .n = n,
              .feed_mm_s = 20,
              .radius_mm = 50};
  return ErrorsOf<Effect>(at, "", {value}).motion_mm.dot(n);
}

TEST(SignsOfGeometry,
     AnAxisYThatLagsMakesACounterClockwiseCircleSmallInTheFirstQuadrant) {
  // At 45 degrees the tip moves to -x and +y: y lags by 20 / sqrt 2 um per ms.
  EXPECT_NEAR(Radial_mm<ServoMismatch>(45, +1, 1), -0.010, kExact);
  EXPECT_NEAR(Radial_mm<ServoMismatch>(45, -1, 1), +0.010, kExact);
  EXPECT_NEAR(Radial_mm<ServoMismatch>(135, +1, 1), +0.010, kExact);
}

TEST(SignsOfGeometry, AServoLagShrinksTheCircleWithFeedSquaredOverRadius) {
  // 10 um at 50 mm/s and 100 mm: (20 / 50)^2 * 2 of it at 20 mm/s and 50 mm.
  EXPECT_NEAR(Radial_mm<ServoLag>(30, +1, 10), -0.0032, kExact);
  EXPECT_NEAR(Radial_mm<ServoLag>(30, -1, 10), -0.0032, kExact);
}

double Face_mm(const Vec3<double>& n, std::string_view artefact, bool inside = false) {
  const At at{.n = n, .on_table = true, .artefact = artefact, .inside = inside};
  return ErrorsOf<BlockSize>(at, "block25", {30}).artefact_mm;
}

TEST(SignsOfGeometry, ALargerBlockMovesSideFacesByHalfAndItsTopByTheWhole) {
  EXPECT_NEAR(Face_mm({1, 0, 0}, "block25"), +0.015, kExact);
  EXPECT_NEAR(Face_mm({0, -1, 0}, "block25"), +0.015, kExact);
  EXPECT_NEAR(Face_mm(kUp, "block25"), +0.030, kExact);
  EXPECT_NEAR(Face_mm({1, 0, 0}, "block25", /*inside=*/true), -0.015, kExact);
  EXPECT_EQ(Face_mm({1, 0, 0}, "block50"), 0);
  EXPECT_EQ(Face_mm(-kUp, "block25"), 0);
}

double Turned_mm(const Vec3<double>& q_mm, const Vec3<double>& n) {
  const At at{.q_mm = q_mm,
              .n = n,
              .on_table = true,
              .artefact = "block",
              .artefact_mid_mm = {150, 150, 0}};
  return ErrorsOf<BlockRotated>(at, "", {2}).artefact_mm;
}

TEST(SignsOfGeometry, ABlockTurnedCounterClockwiseRecedesOnItsRightFaceTowardsTheBack) {
  // 2 mrad: at 20 mm along the face it has moved by 0.04 mm, against +x.
  EXPECT_NEAR(Turned_mm({190, 170, 5}, {1, 0, 0}), -0.040, 40 * 0.002 * 0.002);
  EXPECT_NEAR(Turned_mm({190, 130, 5}, {1, 0, 0}), +0.040, 40 * 0.002 * 0.002);
  EXPECT_NEAR(Turned_mm({170, 190, 5}, {0, 1, 0}), +0.040, 40 * 0.002 * 0.002);
  EXPECT_EQ(Turned_mm({170, 190, 25}, kUp), 0);
}

}  // namespace
}  // namespace caltwin
