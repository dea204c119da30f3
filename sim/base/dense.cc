#include "sim/base/dense.h"

#include <Eigen/Eigenvalues>

namespace caltwin {

Cholesky::Cholesky(const Eigen::MatrixXd& a) : llt_(a) {}

Eigen::VectorXd Cholesky::Solve(const Eigen::VectorXd& right) const {
  return llt_.solve(right);
}

Eigen::MatrixXd Cholesky::SolveEach(const Eigen::MatrixXd& columns) const {
  return llt_.solve(columns);
}

Eigen::VectorXd Cholesky::SolveLower(const Eigen::VectorXd& right) const {
  return llt_.matrixL().solve(right);
}

Eigen::MatrixXd Cholesky::SolveLowerEach(const Eigen::MatrixXd& columns) const {
  return llt_.matrixL().solve(columns);
}

PivotedCholesky::PivotedCholesky(const Eigen::MatrixXd& a) : ldlt_(a) {}

Eigen::VectorXd PivotedCholesky::Solve(const Eigen::VectorXd& right) const {
  return ldlt_.solve(right);
}

Eigen::MatrixXd PivotedCholesky::Inverse() const {
  return ldlt_.solve(Eigen::MatrixXd::Identity(ldlt_.rows(), ldlt_.cols()));
}

Modes ModesOf(const Eigen::MatrixXd& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(symmetric);
  return {.values = solver.eigenvalues(), .vectors = solver.eigenvectors()};
}

Eigen::VectorXd EigenvaluesOf(const Eigen::MatrixXd& symmetric) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(symmetric,
                                                        Eigen::EigenvaluesOnly)
      .eigenvalues();
}

Eigen::VectorXd LeastSquares(const Eigen::MatrixXd& columns,
                             const Eigen::VectorXd& right) {
  return columns.colPivHouseholderQr().solve(right);
}

QrOf::QrOf(const Eigen::MatrixXd& tall) : qr_(tall) {}

Eigen::MatrixXd QrOf::R() const {
  return qr_.matrixQR().topRows(qr_.cols()).triangularView<Eigen::Upper>();
}

Eigen::MatrixXd QrOf::InverseOfR() const {
  return InverseOfUpper(R());
}

Eigen::VectorXd QrOf::SolveR(const Eigen::VectorXd& right) const {
  return qr_.matrixQR().topRows(qr_.cols()).triangularView<Eigen::Upper>().solve(right);
}

Eigen::MatrixXd QrOf::SolveTransposedR(const Eigen::MatrixXd& columns) const {
  const auto upper = qr_.matrixQR().topRows(qr_.cols()).triangularView<Eigen::Upper>();
  return upper.transpose().solve(columns);
}

Eigen::MatrixXd QrOf::Q() const {
  return qr_.householderQ() * Eigen::MatrixXd::Identity(qr_.rows(), qr_.cols());
}

Eigen::VectorXd QrOf::Turned(const Eigen::VectorXd& right) const {
  return qr_.householderQ().adjoint() * right;
}

Eigen::VectorXd QrOf::Solve(const Eigen::VectorXd& right) const {
  return qr_.solve(right);
}

Eigen::MatrixXd InverseOfUpper(const Eigen::MatrixXd& upper) {
  return upper.triangularView<Eigen::Upper>().solve(
      Eigen::MatrixXd::Identity(upper.rows(), upper.cols()));
}

}  // namespace caltwin
