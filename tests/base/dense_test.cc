#include "sim/base/dense.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace caltwin {
namespace {

// [[4, 2], [2, 3]]: L = [[2, 0], [1, sqrt 2]], inverse [[3, -2], [-2, 4]] / 8.
const Eigen::MatrixXd kGram{{4, 2}, {2, 3}};
const Eigen::MatrixXd kInverse{{0.375, -0.25}, {-0.25, 0.5}};
const Eigen::VectorXd kRight = Eigen::Vector2d(1, 2);

constexpr double kRounding = 1e-14;

TEST(Cholesky, HasTheFactorOfTheClosedForm) {
  const Cholesky factor(kGram);

  EXPECT_TRUE(factor.is_definite());
  EXPECT_DOUBLE_EQ(factor.diagonal()[0], 2);
  EXPECT_DOUBLE_EQ(factor.diagonal()[1], std::numbers::sqrt2);
  EXPECT_TRUE(factor.Solve(kRight).isApprox(kInverse * kRight, kRounding));
  EXPECT_TRUE(factor.SolveEach(kGram).isApprox(Eigen::MatrixXd::Identity(2, 2)));
  // L^-1 (1, 2) = (1/2, (2 - 1/2) / sqrt 2).
  const Eigen::Vector2d lower(0.5, 1.5 / std::numbers::sqrt2);
  EXPECT_TRUE(factor.SolveLower(kRight).isApprox(lower, kRounding));
  EXPECT_TRUE(factor.SolveLowerEach(kRight).isApprox(lower, kRounding));
}

TEST(Cholesky, SaysWhatIsNotDefinite) {
  const Eigen::MatrixXd saddle{{1, 2}, {2, 1}};

  EXPECT_FALSE(Cholesky(saddle).is_definite());
}

TEST(PivotedCholesky, InvertsTheClosedForm) {
  const PivotedCholesky factor(kGram);

  EXPECT_TRUE(factor.Solve(kRight).isApprox(kInverse * kRight, kRounding));
  EXPECT_TRUE(factor.Inverse().isApprox(kInverse, kRounding));
}

TEST(Modes, AreThoseOfATurnedDiagonal) {
  // 1 along (1, -1), 3 along (1, 1).
  const Eigen::MatrixXd turned{{2, 1}, {1, 2}};
  const Modes modes = ModesOf(turned);

  EXPECT_TRUE(modes.values.isApprox(Eigen::Vector2d(1, 3), kRounding));
  EXPECT_TRUE(EigenvaluesOf(turned).isApprox(modes.values, kRounding));
  EXPECT_NEAR(modes.vectors.col(0).sum(), 0, kRounding);
  EXPECT_NEAR(std::abs(modes.vectors.col(1).sum()), std::numbers::sqrt2, kRounding);
}

// A line through (0, 1), (1, 3), (2, 4): intercept 7/6, slope 3/2.
const Eigen::MatrixXd kLine{{1, 0}, {1, 1}, {1, 2}};
const Eigen::VectorXd kHeights = Eigen::Vector3d(1, 3, 4);
const Eigen::Vector2d kFitted(7.0 / 6, 1.5);

TEST(LeastSquares, FitsALine) {
  EXPECT_TRUE(LeastSquares(kLine, kHeights).isApprox(kFitted, kRounding));
}

TEST(LeastSquares, TakesColumnsThatDependOnEachOther) {
  Eigen::MatrixXd twice(3, 3);
  twice << kLine, kLine.col(1);

  const Eigen::VectorXd x = LeastSquares(twice, kHeights);

  EXPECT_TRUE((twice * x).isApprox(kLine * kFitted, kRounding));
}

TEST(Qr, IsOrthonormalAndTriangularAndItsProductTheMatrix) {
  const QrOf qr(kLine);

  EXPECT_TRUE((qr.Q().transpose() * qr.Q()).isIdentity(kRounding));
  EXPECT_EQ(qr.R()(1, 0), 0);
  EXPECT_EQ(qr.diagonal()[1], qr.R()(1, 1));
  EXPECT_TRUE((qr.Q() * qr.R()).isApprox(kLine, kRounding));
}

TEST(Qr, SolvesAndTurnsAsItsFactorsDo) {
  const QrOf qr(kLine);

  EXPECT_TRUE(qr.Solve(kHeights).isApprox(kFitted, kRounding));
  EXPECT_TRUE(qr.SolveR(qr.Turned(kHeights).head(2)).isApprox(kFitted, kRounding));
  EXPECT_TRUE((qr.InverseOfR() * qr.R()).isIdentity(kRounding));
  EXPECT_TRUE((qr.R().transpose() * qr.SolveTransposedR(kLine.transpose()))
                  .isApprox(kLine.transpose(), kRounding));
  EXPECT_NEAR(qr.Turned(kHeights).norm(), kHeights.norm(), kRounding * 10);
}

TEST(InverseOfUpper, DoesNotReadBelowTheDiagonal) {
  const Eigen::MatrixXd upper{{2, 1}, {99, 4}};
  const Eigen::MatrixXd inverse{{0.5, -0.125}, {0, 0.25}};

  EXPECT_TRUE(InverseOfUpper(upper).isApprox(inverse, kRounding));
}

}  // namespace
}  // namespace caltwin
