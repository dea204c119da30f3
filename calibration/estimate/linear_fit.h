#pragma once

#include <limits>

#include <Eigen/Core>

namespace caltwin {

/// What a whitened matrix tells of its columns: singular values in descending order and
/// the unit directions they belong to, one a column, as many as the matrix has columns.
///
/// A direction v with singular value s is known with standard deviation 1 / s, in the
/// columns' unit.
struct Spectrum {
  Eigen::VectorXd singular_values{};
  Eigen::MatrixXd directions{};
  int rank = 0;  ///< How many of the directions count as determined.
};

/// When a direction counts as determined.
struct RankRule {
  /// Smallest singular value, as a fraction of the largest: below it the columns are
  /// dependent but for rounding. Scale the columns to like units first.
  double relative = 1e-9;
  /// Largest standard deviation, in the columns' unit: beyond it the noise hides what
  /// algebra could tell.
  double largest_sd = std::numeric_limits<double>::infinity();
};

/// Singular value decomposition of `a` (rows whitened). No rows: rank 0.
Spectrum SpectrumOf(const Eigen::MatrixXd& a, const RankRule& rule = {});

/// A linear estimate, how sure it is, and what the data could not tell.
struct LinearFit {
  bool identifiable = false;  ///< Every column is determined.
  int rank = 0;
  Eigen::VectorXd x{};  ///< The estimate; least-norm where not identifiable.
  /// Of x, for rows whitened to unit variance. Holds only the determined directions: of
  /// the others nothing is known, which no finite number says.
  Eigen::MatrixXd covariance{};
  Eigen::VectorXd weakest{};    ///< Unit direction in x that the data tell least of.
  double weakest_sd = 0;        ///< Along it; infinite where nothing is told.
  Eigen::MatrixXd blind{};      ///< Unit directions not determined, one a column.
  Eigen::VectorXd residuals{};  ///< r - A x, in standard deviations.
  int dof = 0;                  ///< Rows less rank.
  /// Near 1 if sigmas are honest and the model suffices; 0 where dof is 0.
  double chi2_per_dof = 0;

  double sd(Eigen::Index i) const;
};

/// Least squares of A x = r by SVD, rows of A and r already divided by their sigma.
/// No columns or no rows leave x empty and nothing identifiable.
LinearFit SolveLinear(const Eigen::MatrixXd& a,
                      const Eigen::VectorXd& r,
                      const RankRule& rule = {});

/// Standard deviation of a linear combination `weights` . x of an estimate.
double SdOf(const Eigen::VectorXd& weights, const Eigen::MatrixXd& covariance);

}  // namespace caltwin
