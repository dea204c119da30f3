#include <array>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "calibration/estimate/linear_fit.h"
#include "calibration/estimate/robust.h"
#include "calibration/estimate/touch_noise.h"
#include "sim/base/rng.h"

namespace caltwin {
namespace {

// NIST StRD, Norris (linear regression, 36 readings): y, x.
constexpr std::array<std::array<double, 2>, 36> kNorris = {
    {{0.1, 0.2},     {338.8, 337.4}, {118.1, 118.2}, {888.0, 884.6}, {9.2, 10.1},
     {228.1, 226.5}, {668.5, 666.3}, {998.5, 996.3}, {449.1, 448.6}, {778.9, 777.0},
     {559.2, 558.2}, {0.3, 0.4},     {0.1, 0.6},     {778.1, 775.5}, {668.8, 666.9},
     {339.3, 338.0}, {448.9, 447.5}, {10.8, 11.6},   {557.7, 556.0}, {228.3, 228.1},
     {998.0, 995.8}, {888.8, 887.6}, {119.6, 120.2}, {0.3, 0.3},     {0.6, 0.3},
     {557.6, 556.8}, {339.3, 339.1}, {888.0, 887.2}, {998.5, 999.0}, {778.9, 779.0},
     {10.2, 11.1},   {117.6, 118.3}, {228.9, 229.2}, {668.4, 669.1}, {449.2, 448.9},
     {0.2, 0.5}}};

struct Line {
  Eigen::MatrixXd a{};
  Eigen::VectorXd r{};
};

Line Norris() {
  Line line{.a = Eigen::MatrixXd::Ones(36, 2), .r = Eigen::VectorXd(36)};
  for (Eigen::Index i = 0; const auto& [y, x] : kNorris) {
    line.a(i, 1) = x;
    line.r[i++] = y;
  }
  return line;
}

TEST(Robust, NorrisIsFittedAsCertified) {
  const Line norris = Norris();

  const LinearFit fit = SolveLinear(norris.a, norris.r);

  EXPECT_NEAR(fit.x[0], -0.262323073774029, 1e-10);
  EXPECT_NEAR(fit.x[1], 1.00211681802045, 1e-12);
  const double scatter = std::sqrt(fit.chi2_per_dof);
  EXPECT_NEAR(scatter, 0.884796396144373, 1e-10);
  EXPECT_NEAR(scatter * fit.sd(0), 0.232818234301152, 1e-10);
  EXPECT_NEAR(scatter * fit.sd(1), 0.429796848199937e-3, 1e-13);
}

TEST(Robust, OfAMeanHc3IsTheVarianceOverNLessOne) {
  // h = 1 / n, so C^2 sum (e / (1 - 1 / n))^2 = sum e^2 / (n - 1)^2 = s^2 / (n - 1).
  const std::vector<double> readings{1.0, 2.5, -0.7, 4.1, 0.3};
  const Eigen::MatrixXd a = Eigen::MatrixXd::Ones(5, 1);
  const Eigen::VectorXd r = Eigen::Map<const Eigen::VectorXd>(readings.data(), 5);
  const LinearFit fit = SolveLinear(a, r);

  const Eigen::MatrixXd hc3 = SandwichHc3({.rows = a, .residuals = fit.residuals});

  const double s = Scatter(readings);
  EXPECT_NEAR(hc3(0, 0), s * s / 4, 1e-12);
}

TEST(Robust, CopiesOfAReadingTellNothingMore) {
  // Five approaches read three times each, the same thing: the approaches' HC3.
  const std::vector<double> readings{1.0, 2.5, -0.7, 4.1, 0.3};
  const Eigen::MatrixXd a = Eigen::MatrixXd::Ones(15, 1);
  Eigen::VectorXd r(15);
  std::vector<int> groups;
  for (int i = 0; i < 15; ++i) {
    r[i] = readings[static_cast<std::size_t>(i % 5)];
    groups.push_back(i % 5);
  }
  const LinearFit fit = SolveLinear(a, r);

  const Eigen::MatrixXd grouped =
      SandwichByGroup({.rows = a, .residuals = fit.residuals}, groups);

  const double s = Scatter(readings);
  EXPECT_NEAR(grouped(0, 0), s * s / 4, 1e-9);
}

TEST(Robust, ABeliefAloneKeepsItsStatedVariance) {
  // One unknown that no row touches, believed to 1 / 2: variance 1 / 4.
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(4, 1);
  Eigen::MatrixXd known = Eigen::MatrixXd::Constant(1, 1, 2.0);

  const Eigen::MatrixXd hc3 = SandwichHc3(
      {.rows = rows, .residuals = Eigen::VectorXd::Ones(4), .known = known});

  EXPECT_NEAR(hc3(0, 0), 0.25, 1e-12);
}

// A line through rows whose noise grows with x, fitted as if all were alike: how often
// +-1.96 sd hold the slope.
struct Held {
  double plain = 0;
  double robust = 0;
};

Held HowOftenHeld(int trials) {
  constexpr int kRows = 60;
  Rng rng(7, 0, "heteroscedastic");
  Held held;
  for (int trial = 0; trial < trials; ++trial) {
    Eigen::MatrixXd a = Eigen::MatrixXd::Ones(kRows, 2);
    Eigen::VectorXd r(kRows);
    for (int i = 0; i < kRows; ++i) {
      a(i, 1) = (i + 0.5) / kRows;
      r[i] = 2 * std::pow(a(i, 1), 3) * rng.Normal();
    }
    const LinearFit fit = SolveLinear(a, r);
    const double plain_sd = std::sqrt(fit.chi2_per_dof) * fit.sd(1);
    const double robust_sd =
        std::sqrt(SandwichHc3({.rows = a, .residuals = fit.residuals})(1, 1));
    held.plain += std::abs(fit.x[1]) < 1.96 * plain_sd ? 1.0 / trials : 0;
    held.robust += std::abs(fit.x[1]) < 1.96 * robust_sd ? 1.0 / trials : 0;
  }
  return held;
}

TEST(Robust, HoldsTheTruthWhereNoiseGrowsAlongALine) {
  const Held held = HowOftenHeld(2000);

  // Binomial sd of 95 % in 2000: 0.5 %.
  EXPECT_GT(held.robust, 0.93);
  EXPECT_LT(held.robust, 0.97);
  EXPECT_LT(held.plain, 0.91);
}

}  // namespace
}  // namespace caltwin
