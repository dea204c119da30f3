#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "calibration/estimate/tilt_plane.h"
#include "sim/base/rng.h"

namespace caltwin {
namespace {

constexpr double kSlopeX = 0.002;
constexpr double kSlopeY = -0.001;

// A grid of 3 x 3 heights on a plane that is 5 high at the origin.
std::vector<Vec3<double>> Grid() {
  std::vector<Vec3<double>> points;
  for (const double x : {50.0, 150.0, 250.0}) {
    for (const double y : {40.0, 150.0, 260.0}) {
      points.emplace_back(x, y, 5 + kSlopeX * x + kSlopeY * y);
    }
  }
  return points;
}

TEST(TiltPlane, RecoversHeightAndSlopes) {
  const TiltPlane plane = FitTiltPlane(Grid(), 0.001);

  EXPECT_TRUE(plane.slope_x.identifiable);
  EXPECT_NEAR(plane.slope_x.value, kSlopeX, 1e-12);
  EXPECT_NEAR(plane.slope_y.value, kSlopeY, 1e-12);
  EXPECT_NEAR(plane.height_mm.value, 5, 1e-9);
  EXPECT_NEAR(plane.rms_mm, 0, 1e-9);
  EXPECT_EQ(plane.dof, 6);
}

TEST(TiltPlane, StatesTheClosedFormUncertainty) {
  const TiltPlane plane = FitTiltPlane(Grid(), 0.001, {150, 150, 0});

  // At the centre: sigma / sqrt(n); slope: sigma / sqrt(sum (x - mean)^2).
  EXPECT_NEAR(plane.height_mm.sd, 0.001 / 3, 1e-12);
  EXPECT_NEAR(plane.slope_x.sd, 0.001 / std::sqrt(6 * 100.0 * 100), 1e-15);
}

TEST(TiltPlane, ResidualsShowAHighPoint) {
  std::vector<Vec3<double>> points = Grid();
  points[4].z() += 0.09;  // the middle one: the plane rises by a ninth of it

  const TiltPlane plane = FitTiltPlane(points, 0.001);

  EXPECT_NEAR(plane.residuals_mm[4], 0.08, 1e-9);
  EXPECT_NEAR(plane.worst_mm, 0.08, 1e-9);
}

TEST(TiltPlane, CovarianceIsTheScatterOfRepeats) {
  constexpr int kRepeats = 1500;
  constexpr double kSigma_mm = 0.002;
  Rng rng(19, 0, "tilt");
  double squares = 0;
  double stated = 0;

  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    std::vector<Vec3<double>> points = Grid();
    for (Vec3<double>& p : points) p.z() += kSigma_mm * rng.Normal();
    const TiltPlane plane = FitTiltPlane(points, kSigma_mm);
    squares += std::pow(plane.height_mm.value - 5, 2);
    stated += std::pow(plane.height_mm.sd, 2);
  }

  EXPECT_NEAR(squares / stated, 1, 4 * std::sqrt(2.0 / kRepeats));
}

TEST(TiltPlane, ThreePointsFitExactlyAndHaveNothingLeftToJudgeBy) {
  std::vector<Vec3<double>> points = Grid();
  points[0].z() += 1;
  const TiltPlane plane =
      FitTiltPlane(std::vector{points[0], points[2], points[6]}, 0.001);

  EXPECT_TRUE(plane.slope_x.identifiable);
  EXPECT_NEAR(plane.rms_mm, 0, 1e-9);
  EXPECT_EQ(plane.dof, 0);
}

TEST(TiltPlane, PointsOnALineAreNotIdentifiable) {
  const std::vector<Vec3<double>> line = {
      {0, 0, 1}, {50, 50, 2}, {100, 100, 3}, {200, 200, 5}};

  EXPECT_FALSE(FitTiltPlane(line, 0.001).slope_x.identifiable);
  EXPECT_FALSE(FitTiltPlane({}, 0.001).height_mm.identifiable);
}

}  // namespace
}  // namespace caltwin
