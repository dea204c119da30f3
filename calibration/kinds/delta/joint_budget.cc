#include "calibration/kinds/delta/joint_budget.h"

#include <cmath>

namespace caltwin {

std::vector<Contribution> BudgetOf(const WeighedFit& fit, Eigen::Index i) {
  constexpr double kLittle = 1e-3;
  const Eigen::VectorXd column = fit.covariance.col(i);
  const Eigen::VectorXd moved =
      fit.weights.cwiseSqrt().cwiseProduct(fit.slope * column);
  const double least = kLittle * fit.covariance(i, i);
  std::vector<Contribution> budget;
  Eigen::Index row = 0;
  for (const WeighedFit::Group& group : fit.groups) {
    const double u = moved.segment(row, group.rows).norm();
    row += group.rows;
    if (u > 0) budget.push_back({.input = group.name, .u = u});
  }
  double little = 0;
  for (std::size_t k = 0; k < fit.prior_sd.size(); ++k) {
    const double u = std::abs(column[static_cast<Eigen::Index>(k)]) / fit.prior_sd[k];
    if (u * u >= least) {
      budget.push_back({.input = "prior of " + fit.names[k], .u = u});
    } else {
      little = std::hypot(little, u);
    }
  }
  if (little > 0) budget.push_back({.input = "other priors", .u = little});
  return budget;
}

}  // namespace caltwin
