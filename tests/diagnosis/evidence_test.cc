// The evidence against the textbook: the marginal likelihood of a dense normal model,
// its noise scale integrated out, computed the long way.
#include "calibration/diagnosis/evidence.h"

#include <cmath>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "sim/base/rng.h"

namespace caltwin {
namespace {

constexpr double kSigma_mm = 1e-3;
constexpr Eigen::Index kRows = 40;

Machine Plain() {
  Machine machine{.name = "test"};
  machine.settings.steps_per_mm = {800, 800, 800};
  return machine;
}

// Gauge rows along x with normal noise.
RowTable Line(std::uint64_t seed) {
  Rng rng(seed, 0, "evidence_test");
  RowTable table;
  for (Eigen::Index i = 0; i < kRows; ++i) {
    Row row{.row = i + 1, .campaign = "line"};
    row.t_s = static_cast<double>(10 * i);
    row.cmd_mm = {7.3 * static_cast<double>(i), 0, 0};
    row.dir = {i % 2 == 0 ? 1.0 : -1.0, 0, 0};
    row.n = {1, 0, 0};
    row.value_mm = kSigma_mm * rng.Normal();
    table.rows.push_back(row);
  }
  return table;
}

Eigen::MatrixXd SomeColumns() {
  Eigen::MatrixXd columns(kRows, 2);
  for (Eigen::Index i = 0; i < kRows; ++i) {
    columns(i, 0) = std::sin(0.7 * static_cast<double>(i));
    columns(i, 1) = i > 20 ? 1 : 0;
  }
  return columns;
}

Nuisance Known(const char* name, const Eigen::VectorXd& column, double prior_sd) {
  return {.name = name, .unit = "mm", .column_mm = column, .prior_sd = prior_sd};
}

// log of (r' V^-1 r)^(-dof/2) |V|^(-1/2), V = sigma^2 I + B P B' (+ columns D
// columns').
double LogMarginal(const Eigen::MatrixXd& covariance,
                   const Eigen::VectorXd& residual,
                   double dof) {
  const Eigen::LLT<Eigen::MatrixXd> llt(covariance);
  const Eigen::VectorXd diagonal = llt.matrixLLT().diagonal();
  return -diagonal.array().log().sum() -
         dof / 2 * std::log(residual.dot(llt.solve(residual)));
}

TEST(Evidence, LogBayesIsTheRatioOfTwoMarginalLikelihoods) {
  const Observed observed(Line(3), {}, Plain(), {});
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(kRows);
  const std::vector<Nuisance> nuisances = {Known("offset", ones, 0.05)};
  const Eigen::VectorXd sigma = ones * kSigma_mm;
  const Evidence evidence(observed, {sigma, 0}, nuisances);
  const Eigen::MatrixXd columns = SomeColumns();
  const Eigen::Vector2d prior(4e-6, 1e-6);

  const double found =
      evidence.LogBayes(evidence.Project(evidence.Whiten(columns)), prior);

  Eigen::MatrixXd none = 0.05 * 0.05 * ones * ones.transpose();
  none.diagonal().array() += kSigma_mm * kSigma_mm;
  const Eigen::MatrixXd some =
      none + columns * prior.asDiagonal() * columns.transpose();
  const Eigen::VectorXd& r = observed.residual_mm();
  const double expected =
      LogMarginal(some, r, evidence.dof()) - LogMarginal(none, r, evidence.dof());
  EXPECT_NEAR(found, expected, 1e-6);
}

TEST(Evidence, RowsLeftOutSayNothing) {
  RowTable table = Line(5);
  const Observed clean(table, {}, Plain(), {});
  table.rows[7].value_mm = 1;
  const Observed spoilt(table, {}, Plain(), {});
  const Eigen::VectorXd sigma = Eigen::VectorXd::Constant(kRows, kSigma_mm);
  const std::vector<Nuisance> nuisances = {
      Known("offset", Eigen::VectorXd::Ones(kRows), 10)};
  std::vector<bool> out(static_cast<std::size_t>(kRows), false);
  out[7] = true;

  const Evidence with(clean, {sigma, 0}, nuisances, out);
  const Evidence without(spoilt, {sigma, 0}, nuisances, out);

  EXPECT_DOUBLE_EQ(with.chi2(), without.chi2());
  EXPECT_DOUBLE_EQ(with.dof(), without.dof());
}

// The identity against the long way: each group left out, all fitted anew.
TEST(Evidence, ForetellsAGroupAsAFitWithoutItDoes) {
  const Observed observed(Line(11), {}, Plain(), {});
  const Eigen::VectorXd sigma = Eigen::VectorXd::Constant(kRows, kSigma_mm);
  const Eigen::MatrixXd columns = SomeColumns();
  const std::vector<Nuisance> nuisances = {
      Known("offset", Eigen::VectorXd::Ones(kRows), 10),
      Known("wave", columns.col(0), 0.002),
      Known("step", columns.col(1), 1)};
  std::vector<bool> out(static_cast<std::size_t>(kRows), false);
  out[3] = true;
  std::vector<int> group_of(static_cast<std::size_t>(kRows));
  // The last group is all that lies behind the step: its prior alone is left of it.
  for (std::size_t i = 0; i < group_of.size(); ++i) {
    group_of[i] = i > 20 ? 3 : static_cast<int>(i % 4) - 1;
  }
  const Evidence all(observed, {sigma, 0}, nuisances, out);
  const Evidence::Foretold foretold = all.Foretell(group_of);

  for (int group = 0; group < 4; ++group) {
    std::vector<bool> without = out;
    for (std::size_t i = 0; i < out.size(); ++i) {
      if (group_of[i] == group) without[i] = true;
    }
    const Evidence others(observed, {sigma, 0}, nuisances, without);
    const Evidence::Fit fit = others.FitNuisances();
    const double scale = std::sqrt(others.chi2() / others.dof());
    for (std::size_t i = 0; i < out.size(); ++i) {
      if (group_of[i] != group || out[i]) continue;
      const auto row = static_cast<Eigen::Index>(i);
      EXPECT_NEAR(foretold.residual_mm[row], fit.residual_mm[row], 1e-9) << i;
      const double sd_mm = fit.sd_mm[row] / scale;
      EXPECT_NEAR(foretold.sd_mm[row] / sd_mm, 1, 1e-5) << i;
    }
  }
}

TEST(Whitener, WanderMakesInnovationsWithTheCovariancesDeterminant) {
  const Observed observed(Line(7), {}, Plain(), {});
  const Eigen::VectorXd sigma = Eigen::VectorXd::Constant(kRows, kSigma_mm);
  constexpr double kRate_mm2_per_s = 1e-8;
  const Whitener whiten(observed, {sigma, kRate_mm2_per_s});

  Eigen::MatrixXd covariance(kRows, kRows);
  for (Eigen::Index i = 0; i < kRows; ++i) {
    for (Eigen::Index k = 0; k < kRows; ++k) {
      covariance(i, k) = kRate_mm2_per_s * 10 * static_cast<double>(std::min(i, k));
      if (i == k) covariance(i, k) += kSigma_mm * kSigma_mm;
    }
  }
  const Eigen::LLT<Eigen::MatrixXd> llt(covariance);
  const Eigen::VectorXd diagonal = llt.matrixLLT().diagonal();
  const Eigen::MatrixXd columns = SomeColumns();
  const Eigen::MatrixXd white = whiten(columns);

  EXPECT_NEAR(whiten.log_det(), 2 * diagonal.array().log().sum(), 1e-8);
  EXPECT_NEAR(white.col(0).dot(white.col(1)),
              columns.col(0).dot(llt.solve(columns.col(1))),
              1e-4);
}

}  // namespace
}  // namespace caltwin
