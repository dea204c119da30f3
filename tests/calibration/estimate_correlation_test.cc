// Correlations are those of closed forms.

#include <cmath>

#include <gtest/gtest.h>

#include "calibration/estimate/correlation.h"
#include "calibration/estimate/tilt_plane.h"
#include "calibration/kinds/triple_z/response.h"

namespace caltwin {
namespace {

// A line y = a + b x fitted to readings at these places: r = -mean(x) / rms(x).
TEST(Correlations, OfALineAreThoseOfItsPlaces) {
  const Eigen::Vector4d x(1, 2, 4, 9);
  Eigen::MatrixXd a(4, 2);
  a << Eigen::Vector4d::Ones(), x;
  const Eigen::MatrixXd covariance = (a.transpose() * a).inverse();
  const Correlations of = CorrelationsOf("line", {"a", "b"}, covariance);

  EXPECT_NEAR(of.matrix(0, 1), -x.mean() / std::sqrt(x.squaredNorm() / 4), 1e-12);
  EXPECT_EQ(of.matrix(1, 0), of.matrix(0, 1));
  EXPECT_EQ(of.matrix(0, 0), 1);
}

TEST(Correlations, AreTheSameInAnyUnits) {
  const Eigen::Matrix2d covariance{{4e-6, 3e-3}, {3e-3, 9}};
  const Eigen::Vector2d units(1e3, -2);
  const Eigen::Matrix2d other = units.asDiagonal() * covariance * units.asDiagonal();

  EXPECT_NEAR(CorrelationsOf("", {"p", "q"}, covariance).matrix(0, 1), 0.5, 1e-12);
  EXPECT_NEAR(CorrelationsOf("", {"p", "q"}, other).matrix(0, 1), -0.5, 1e-12);
}

TEST(Correlations, TellTheLargestPairsFirst) {
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
  covariance(0, 1) = covariance(1, 0) = 0.2;
  covariance(1, 2) = covariance(2, 1) = -0.7;
  const Correlations of = CorrelationsOf("", {"p", "q", "s"}, covariance);

  EXPECT_EQ(MostCorrelatedText(of), "q with s -0.70, p with q +0.20");
  ASSERT_EQ(LargestPairs(of, 1, 0).size(), 1U);
  EXPECT_EQ(LargestPairs(of, 1, 0)[0].r, -0.7);
}

TEST(Correlations, OfManyTellHowManyMoreThereAre) {
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Constant(0.5);
  covariance.diagonal().setOnes();

  EXPECT_EQ(MostCorrelatedText(CorrelationsOf("", {"p", "q", "s", "t"}, covariance)),
            "p with q +0.50, p with s +0.50, p with t +0.50, 3 more of 0.3 and more");
}

TEST(Correlations, WithoutAnyThereIsNothingToSay) {
  EXPECT_EQ(MostCorrelatedText(CorrelationsOf("", {"p", "q"}, Eigen::Matrix2d::Zero())),
            "");
}

// Slopes touched at three corners: of (0, 0), (1, 0), (0, 1) the first height counts
// against both, so their covariance is its variance.
TEST(Correlations, OfSlopesBySharedCornersAreAHalf) {
  const std::vector<Vec3<double>> corners_mm = {{0, 0, 0}, {100, 0, 0}, {0, 100, 0}};
  const TiltPlane plane = FitTiltPlane(corners_mm, 0.002);

  EXPECT_NEAR(plane.slope_covariance, std::pow(0.002 / 100, 2), 1e-15);
  EXPECT_NEAR(
      plane.slope_covariance / (plane.slope_x.sd * plane.slope_y.sd), 0.5, 1e-9);
}

}  // namespace
}  // namespace caltwin
