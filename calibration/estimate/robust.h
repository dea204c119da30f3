#pragma once

#include <span>

#include <Eigen/Core>

namespace caltwin {

/// What a robust covariance is made of: a least-squares fit at its solution.
struct Sandwich {
  Eigen::MatrixXd rows{};       ///< A: whitened, one an observation.
  Eigen::VectorXd residuals{};  ///< In the same standard deviations.
  Eigen::MatrixXd known{};      ///< Rows of beliefs, whose sd is taken as stated.
};

/// Covariance from the residuals themselves, where nobody knows the noise of each row
/// or it differs from row to row (White 1980; HC3 of MacKinnon and White 1985):
///
///   C (sum a_i a_i^T (e_i / (1 - h_i))^2 + K) C,   C = (A^T A + K)^-1,  h_i = a_i^T C
///   a_i
///
/// with K the beliefs' information. Rows are independent of each other in it; of n rows
/// and p unknowns it is a little too large rather than too small (n / (n - p)). A row
/// that alone tells an unknown (h_i = 1) leaves no residual: counted at 1 - h = 1e-6.
Eigen::MatrixXd SandwichHc3(const Sandwich& fit);

/// The same where rows of a group err together (touches of one approach, one setup):
/// CR3, sum over groups of A_g^T f_g f_g^T A_g with f_g = (1 - A_g C A_g^T)^-1 e_g. Few
/// groups tell little: Student's t with groups - 1 degrees of freedom.
/// @param groups  of each row, numbered from 0
Eigen::MatrixXd SandwichByGroup(const Sandwich& fit, std::span<const int> groups);

}  // namespace caltwin
