// Decompositions of dense matrices, compiled once. Each file that names one of Eigen's
// compiles it again: three seconds a decomposition, in dozens of files.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/QR>

namespace caltwin {

/// Cholesky factor of a positive definite matrix, a = L L^T.
class Cholesky {
 public:
  explicit Cholesky(const Eigen::MatrixXd& a);

  bool is_definite() const { return llt_.info() == Eigen::Success; }
  /// Diagonal of L.
  auto diagonal() const { return llt_.matrixLLT().diagonal(); }
  /// a^-1 right.
  Eigen::VectorXd Solve(const Eigen::VectorXd& right) const;
  Eigen::MatrixXd SolveEach(const Eigen::MatrixXd& columns) const;
  /// L^-1 right.
  Eigen::VectorXd SolveLower(const Eigen::VectorXd& right) const;
  Eigen::MatrixXd SolveLowerEach(const Eigen::MatrixXd& columns) const;

 private:
  Eigen::LLT<Eigen::MatrixXd> llt_;
};

/// Pivoted factor of a symmetric, semidefinite matrix, a = P^T L D L^T P.
class PivotedCholesky {
 public:
  explicit PivotedCholesky(const Eigen::MatrixXd& a);

  /// a^-1 right.
  Eigen::VectorXd Solve(const Eigen::VectorXd& right) const;
  /// a^-1.
  Eigen::MatrixXd Inverse() const;

 private:
  Eigen::LDLT<Eigen::MatrixXd> ldlt_;
};

/// Eigenvalues of a symmetric matrix, ascending, and their unit vectors as columns.
struct Modes {
  Eigen::VectorXd values{};
  Eigen::MatrixXd vectors{};
};
Modes ModesOf(const Eigen::MatrixXd& symmetric);

/// The values alone, ascending; cheaper.
Eigen::VectorXd EigenvaluesOf(const Eigen::MatrixXd& symmetric);

/// x of least |columns x - right|; pivoted Householder, so columns may depend on each
/// other.
Eigen::VectorXd LeastSquares(const Eigen::MatrixXd& columns,
                             const Eigen::VectorXd& right);

/// Householder's Q R of a matrix with more rows than columns, which are independent.
class QrOf {
 public:
  QrOf() = default;
  explicit QrOf(const Eigen::MatrixXd& tall);

  /// R, square; below its diagonal nought.
  Eigen::MatrixXd R() const;
  /// Diagonal of R.
  auto diagonal() const { return qr_.matrixQR().diagonal(); }
  /// R^-1.
  Eigen::MatrixXd InverseOfR() const;
  /// R^-1 right.
  Eigen::VectorXd SolveR(const Eigen::VectorXd& right) const;
  /// R^-T columns.
  Eigen::MatrixXd SolveTransposedR(const Eigen::MatrixXd& columns) const;
  /// Q's columns, as many as those of the matrix.
  Eigen::MatrixXd Q() const;
  /// Q^T right of the square Q: as long as the matrix is tall.
  Eigen::VectorXd Turned(const Eigen::VectorXd& right) const;
  /// x of least |tall x - right|.
  Eigen::VectorXd Solve(const Eigen::VectorXd& right) const;

 private:
  Eigen::HouseholderQR<Eigen::MatrixXd> qr_{};
};

/// upper^-1 of a triangular matrix; what stands below its diagonal is not read.
Eigen::MatrixXd InverseOfUpper(const Eigen::MatrixXd& upper);

}  // namespace caltwin
