#pragma once

#include <array>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "calibration/estimate/uncertain.h"

namespace caltwin {

/// A weighted least-squares fit with priors, as its budget needs it.
struct WeighedFit {
  Eigen::MatrixXd slope{};       ///< Of residuals in sigma, by unknown.
  Eigen::VectorXd weights{};     ///< Of residuals: Huber's, 1 within.
  Eigen::MatrixXd covariance{};  ///< C = (A^T W A + P^-1)^-1.
  std::vector<double> prior_sd{};
  std::vector<std::string> names{};  ///< Of the unknowns.
  /// The rows are those of these groups, one group after the other.
  struct Group {
    std::string name{};
    Eigen::Index rows = 0;
  };
  std::vector<Group> groups{};
};

/// The GUM budget of unknown `i`, in its unit:
///
///   C_ii = sum over groups of |W_g^1/2 A_g c_i|^2 + sum over unknowns (C_ik / p_k)^2
///
/// with c_i the i-th column of C. What is below a thousandth of the variance is put
/// together as "other priors".
std::vector<Contribution> BudgetOf(const WeighedFit& fit, Eigen::Index i);

}  // namespace caltwin
