#include "calibration/diagnosis/evidence.h"

#include <algorithm>
#include <cmath>

#include "calibration/estimate/inner_products.h"
#include "sim/base/dense.h"
#include "sim/base/require.h"

namespace caltwin {
namespace {

using Block = Eigen::Ref<const Eigen::MatrixXd>;

ColumnsView ViewOf(const Block& columns) {
  return {columns.data(), columns.rows(), columns.cols(), columns.outerStride()};
}

// a' b
Eigen::MatrixXd Products(const Block& a, const Block& b) {
  Eigen::MatrixXd products(a.cols(), b.cols());
  InnerProducts(ViewOf(a), ViewOf(b), products.data());
  return products;
}

}  // namespace

Evidence::Evidence(const Observed& observed,
                   const Noise& noise,
                   const std::vector<Nuisance>& nuisances,
                   const std::vector<bool>& left_out)
    : observed_(&observed),
      whitener_(observed, noise),
      keep_(Eigen::VectorXd::Ones(observed.num_rows())),
      sigma_mm_(noise.sigma_mm) {
  const Eigen::Index n = observed.num_rows();
  const auto q = static_cast<Eigen::Index>(nuisances.size());
  for (std::size_t i = 0; i < left_out.size(); ++i) {
    if (left_out[i]) keep_[static_cast<Eigen::Index>(i)] = 0;
  }
  columns_mm_.resize(n, q);
  prior_sd_.resize(q);
  for (Eigen::Index k = 0; k < q; ++k) {
    const Nuisance& nuisance = nuisances[static_cast<std::size_t>(k)];
    columns_mm_.col(k) = nuisance.column_mm;
    prior_sd_[k] = nuisance.prior_sd;
  }
  white_residual_ = Whiten(observed.residual_mm());
  // In units of the prior: pseudo readings are then an identity below.
  Eigen::MatrixXd tall(n + q, q);
  tall.topRows(n) = Whiten(columns_mm_) * prior_sd_.asDiagonal();
  tall.bottomRows(q).setIdentity();
  qr_ = QrOf(tall);
  Eigen::VectorXd readings = Eigen::VectorXd::Zero(n + q);
  readings.head(n) = white_residual_;
  taken_ = qr_.Turned(readings).head(q);
  chi2_ = std::max(white_residual_.squaredNorm() - taken_.squaredNorm(), 1e-30);
  // Each nuisance pays for what the rows, not its prior, say of it: 1 less the square
  // of its part of Q in the pseudo rows, which is R^-1.
  const Eigen::MatrixXd inverse = qr_.InverseOfR();
  const double paid = static_cast<double>(q) - inverse.squaredNorm();
  dof_ = std::max(1.0, keep_.sum() - paid);
  log_none_ = -0.5 * whitener_.log_det() - qr_.diagonal().array().abs().log().sum() -
              0.5 * dof_ * std::log(chi2_);
}

const Eigen::MatrixXd& Evidence::Q() const {
  if (q_.size() == 0 && prior_sd_.size() > 0) {
    const Eigen::Index n = observed_->num_rows();
    q_ = qr_.Q().topRows(n);
  }
  return q_;
}

Eigen::MatrixXd Evidence::Whiten(const Eigen::MatrixXd& columns_mm) const {
  Eigen::MatrixXd white = whitener_(columns_mm);
  white.array().colwise() *= keep_.array();
  return white;
}

Projected Evidence::ProjectPart(const Eigen::Ref<const Eigen::MatrixXd>& white,
                                const Eigen::Ref<const Eigen::MatrixXd>& along) const {
  Projected projected;
  projected.gram = Products(white, white) - Products(along, along);
  projected.match = white.transpose() * white_residual_;
  projected.match -= along.transpose() * taken_;
  // What the baseline takes all but a billionth of is not there: rounding would be
  // taken for it.
  constexpr double kInvisible = 1e-9;
  projected.gram.diagonal() += kInvisible * white.colwise().squaredNorm().transpose();
  return projected;
}

Projected Evidence::Project(const Eigen::MatrixXd& white) const {
  return ProjectPart(white, Products(Q(), white));
}

std::vector<Projected> Evidence::ProjectEach(
    std::span<const Eigen::MatrixXd* const> sets_mm) const {
  constexpr Eigen::Index kColumnsAtOnce = 64;  // What fits into a core's cache.
  std::vector<Projected> all;
  for (std::size_t next = 0; next < sets_mm.size();) {
    const std::size_t first = next;
    Eigen::Index num = 0;
    while (next < sets_mm.size() && (num == 0 || num < kColumnsAtOnce)) {
      num += sets_mm[next++]->cols();
    }
    Eigen::MatrixXd columns_mm(observed_->num_rows(), num);
    Eigen::Index at = 0;
    for (std::size_t k = first; k < next; ++k) {
      columns_mm.middleCols(at, sets_mm[k]->cols()) = *sets_mm[k];
      at += sets_mm[k]->cols();
    }
    const Eigen::MatrixXd white = Whiten(columns_mm);
    const Eigen::MatrixXd along = Products(Q(), white);
    at = 0;
    for (std::size_t k = first; k < next; ++k) {
      const Eigen::Index own = sets_mm[k]->cols();
      all.push_back(ProjectPart(white.middleCols(at, own), along.middleCols(at, own)));
      at += own;
    }
  }
  return all;
}

Eigen::MatrixXd Evidence::Left(const Eigen::MatrixXd& white) const {
  return white - Q() * Products(Q(), white);
}

Eigen::MatrixXd Evidence::ProjectedReadings(
    const Eigen::MatrixXd& white_readings) const {
  return Left(keep_.asDiagonal() * white_readings);
}

double LogBayesOf(const Projected& projected,
                  const Eigen::VectorXd& prior,
                  double chi2,
                  double dof) {
  // In units of the prior: I + S A S, S = D^(1/2).
  const Eigen::VectorXd sd = prior.cwiseSqrt();
  Eigen::MatrixXd inner = sd.asDiagonal() * projected.gram * sd.asDiagonal();
  inner.diagonal().array() += 1;
  const Cholesky cholesky(inner);
  if (!cholesky.is_definite()) return -1e300;
  const Eigen::VectorXd scaled = cholesky.SolveLower(sd.cwiseProduct(projected.match));
  const Eigen::VectorXd diagonal = cholesky.diagonal();
  const double log_det = 2 * diagonal.array().log().sum();
  // What is left below the noise is no better for that: exact rows have whole steps.
  constexpr double kLeft = 0.5;  // Of what noise leaves.
  const double most = std::clamp(1 - kLeft * dof / chi2, 0.0, 1 - 1e-12);
  const double explained = std::clamp(scaled.squaredNorm() / chi2, 0.0, most);
  return -0.5 * log_det - 0.5 * dof * std::log1p(-explained);
}

double Evidence::LogBayes(const Projected& projected,
                          const Eigen::VectorXd& prior) const {
  return LogBayesOf(projected, prior, chi2_, dof_);
}

Evidence::Fit Evidence::FitNuisances() const {
  Fit fit;
  const Eigen::VectorXd scaled = qr_.SolveR(taken_);
  fit.values = prior_sd_.cwiseProduct(scaled);
  const Eigen::MatrixXd inverse = qr_.InverseOfR();
  const double scale = std::sqrt(chi2_ / dof_);
  fit.half = prior_sd_.asDiagonal() * inverse * scale;
  fit.sds = fit.half.rowwise().norm();
  fit.residual_mm = observed_->residual_mm() - columns_mm_ * fit.values;
  fit.sd_mm = (columns_mm_ * fit.half).rowwise().norm();
  return fit;
}

Evidence::Foretold Evidence::Foretell(const std::vector<int>& group_of) const {
  std::vector<std::vector<Eigen::Index>> groups;
  for (std::size_t i = 0; i < group_of.size(); ++i) {
    if (group_of[i] < 0) continue;
    const auto g = static_cast<std::size_t>(group_of[i]);
    if (g >= groups.size()) groups.resize(g + 1);
    groups[g].push_back(static_cast<Eigen::Index>(i));
  }
  Foretold foretold{.residual_mm = white_residual_ - Q() * taken_,
                    .sd_mm = Eigen::VectorXd::Zero(white_residual_.size())};
  const Eigen::Index q = prior_sd_.size();
  for (const std::vector<Eigen::Index>& rows : groups) {
    const Eigen::MatrixXd own = Q()(rows, Eigen::all);
    // The prior alone is left of what only this group tells: small, never nothing.
    Eigen::MatrixXd others = Eigen::MatrixXd::Identity(q, q);
    others.noalias() -= own.transpose() * own;
    Cholesky cholesky(others);
    if (!cholesky.is_definite()) {
      // Beside rows without noise a prior is less than what 16 digits hold.
      constexpr double kRounding = 1e-12;
      others.diagonal().array() += kRounding;
      cholesky = Cholesky(others);
    }
    Require(cholesky.is_definite(), "every nuisance has a prior");
    const Eigen::MatrixXd half = cholesky.SolveLowerEach(own.transpose());
    const Eigen::VectorXd left = foretold.residual_mm(rows);
    foretold.residual_mm(rows) += half.transpose() * (half * left);
    foretold.sd_mm(rows) = half.colwise().norm().transpose();
  }
  foretold.residual_mm.array() *= sigma_mm_.array();
  foretold.sd_mm.array() *= sigma_mm_.array();
  return foretold;
}

}  // namespace caltwin
