#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/estimate/linear_fit.h"
#include "sim/base/rng.h"

namespace caltwin {
namespace {

// A line through five points, each with standard deviation sigma: the textbook's own
// closed forms hold.
constexpr double kSigma = 0.5;
const Eigen::VectorXd kAt = Eigen::VectorXd::LinSpaced(5, 1, 5);

Eigen::MatrixXd Line() {
  Eigen::MatrixXd a(5, 2);
  a.col(0).setOnes();
  a.col(1) = kAt;
  return a / kSigma;
}

TEST(LinearFit, RecoversALineExactly) {
  const Eigen::Vector2d truth(3, -2);

  const LinearFit fit = SolveLinear(Line(), Line() * truth);

  EXPECT_TRUE(fit.identifiable);
  EXPECT_NEAR(fit.x[0], 3, 1e-12);
  EXPECT_NEAR(fit.x[1], -2, 1e-12);
  EXPECT_NEAR(fit.chi2_per_dof, 0, 1e-20);
  EXPECT_EQ(fit.dof, 3);
}

TEST(LinearFit, StatesTheTextbookCovarianceOfALine) {
  const LinearFit fit = SolveLinear(Line(), Eigen::VectorXd::Zero(5));

  // var(slope) = sigma^2 / sum (x - mean)^2, sum = 10; var(intercept) = sigma^2 (1/n +
  // mean^2 / sum), mean = 3.
  EXPECT_NEAR(fit.sd(1), kSigma / std::sqrt(10), 1e-12);
  EXPECT_NEAR(fit.sd(0), kSigma * std::sqrt(1.0 / 5 + 9.0 / 10), 1e-12);
  EXPECT_NEAR(fit.covariance(0, 1), -3 * kSigma * kSigma / 10, 1e-12);
}

TEST(LinearFit, ScatterOfRepeatsIsTheStatedCovarianceAndChi2IsOne) {
  constexpr int kRepeats = 2000;
  Rng rng(1, 0, "linear_fit");
  double slope_squares = 0;
  double chi2 = 0;

  double stated = 0;
  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    const Eigen::VectorXd noise =
        Eigen::VectorXd::NullaryExpr(5, [&](Eigen::Index) { return rng.Normal(); });
    const LinearFit fit = SolveLinear(Line(), noise);
    slope_squares += fit.x[1] * fit.x[1];
    chi2 += fit.chi2_per_dof;
    stated = fit.covariance(1, 1);
  }

  // A variance from N repeats has relative sd sqrt(2 / N), a mean of chi2/dof with 3
  // degrees of freedom sqrt(2 / 3N).
  EXPECT_NEAR(slope_squares / kRepeats / stated, 1, 4 * std::sqrt(2.0 / kRepeats));
  EXPECT_NEAR(chi2 / kRepeats, 1, 4 * std::sqrt(2.0 / (3 * kRepeats)));
}

TEST(LinearFit, SaysWhichDirectionIsBlind) {
  // Two columns that are one but for a factor: only a + 2 b is told.
  Eigen::MatrixXd a(3, 2);
  a << 1, 2, 2, 4, 3, 6;

  const LinearFit fit = SolveLinear(a, Eigen::Vector3d(5, 10, 15));

  EXPECT_FALSE(fit.identifiable);
  EXPECT_EQ(fit.rank, 1);
  ASSERT_EQ(fit.blind.cols(), 1);
  EXPECT_NEAR(
      std::abs(fit.blind.col(0).dot(Eigen::Vector2d(2, -1))), std::sqrt(5), 1e-9);
  EXPECT_TRUE(std::isinf(fit.weakest_sd));
  EXPECT_NEAR(fit.x[0] + 2 * fit.x[1], 5, 1e-9);
}

TEST(LinearFit, FewerRowsThanColumnsAreNotIdentifiable) {
  const LinearFit fit =
      SolveLinear(Eigen::MatrixXd::Ones(1, 3), Eigen::VectorXd::Ones(1));

  EXPECT_FALSE(fit.identifiable);
  EXPECT_EQ(fit.blind.cols(), 2);
  EXPECT_EQ(fit.dof, 0);
}

TEST(LinearFit, NoRowsTellNothing) {
  const LinearFit fit = SolveLinear(Eigen::MatrixXd(0, 2), Eigen::VectorXd(0));

  EXPECT_FALSE(fit.identifiable);
  EXPECT_EQ(fit.x.size(), 0);
}

TEST(LinearFit, NoiseCanHideWhatAlgebraTells) {
  // Singular value 0.5: a standard deviation of 2.
  const Eigen::MatrixXd a = Eigen::Vector2d(100, 0.5).asDiagonal();
  const Eigen::Vector2d r(100, 0.5);

  EXPECT_TRUE(SolveLinear(a, r, {.largest_sd = 3}).identifiable);
  EXPECT_FALSE(SolveLinear(a, r, {.largest_sd = 1}).identifiable);
}

}  // namespace
}  // namespace caltwin
