#include "calibration/estimate/linear_fit.h"

#include <algorithm>
#include <cmath>

#include <Eigen/SVD>

#include "sim/base/require.h"

namespace caltwin {

Spectrum SpectrumOf(const Eigen::MatrixXd& a, const RankRule& rule) {
  const Eigen::Index columns = a.cols();
  if (columns == 0) return {};

  // Rows of zeros say nothing, and give every column its direction where rows are few.
  Eigen::MatrixXd tall = Eigen::MatrixXd::Zero(std::max(a.rows(), columns), columns);
  tall.topRows(a.rows()) = a;
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(tall, Eigen::ComputeThinV);

  Spectrum spectrum{.singular_values = svd.singularValues(),
                    .directions = svd.matrixV()};
  const double smallest =
      std::max(rule.relative * spectrum.singular_values[0], 1 / rule.largest_sd);
  for (const double s : spectrum.singular_values) {
    if (s > smallest) ++spectrum.rank;
  }
  return spectrum;
}

double LinearFit::sd(Eigen::Index i) const {
  return std::sqrt(covariance(i, i));
}

LinearFit SolveLinear(const Eigen::MatrixXd& a,
                      const Eigen::VectorXd& r,
                      const RankRule& rule) {
  Require(a.rows() == r.size(), "as many right-hand sides as rows");
  if (a.rows() == 0 || a.cols() == 0) return {};

  const Spectrum spectrum = SpectrumOf(a, rule);
  const Eigen::Index rank = spectrum.rank;
  const Eigen::MatrixXd known = spectrum.directions.leftCols(rank);
  const Eigen::VectorXd s = spectrum.singular_values.head(rank);
  const Eigen::VectorXd projected = (a * known).transpose() * r;
  const double last = spectrum.singular_values[a.cols() - 1];

  LinearFit fit;
  fit.rank = spectrum.rank;
  fit.identifiable = rank == a.cols();
  fit.x = known * projected.cwiseQuotient(s.cwiseAbs2());
  fit.covariance =
      known * s.cwiseAbs2().cwiseInverse().asDiagonal() * known.transpose();
  fit.weakest = spectrum.directions.rightCols(1);
  fit.weakest_sd =
      fit.identifiable ? 1 / last : std::numeric_limits<double>::infinity();
  fit.blind = spectrum.directions.rightCols(a.cols() - rank);
  fit.residuals = r - a * fit.x;
  const auto rows = static_cast<int>(a.rows());
  fit.dof = rows - fit.rank;
  fit.chi2_per_dof = fit.dof > 0 ? fit.residuals.squaredNorm() / fit.dof : 0;
  return fit;
}

double SdOf(const Eigen::VectorXd& weights, const Eigen::MatrixXd& covariance) {
  return std::sqrt(std::max(0.0, weights.dot(covariance * weights)));
}

}  // namespace caltwin
