#include "calibration/estimate/robust.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Dense>

#include "sim/base/dense.h"
#include "sim/base/require.h"

namespace caltwin {
namespace {

constexpr double kLeast = 1e-6;  // Of 1 - h.

Eigen::MatrixXd InformationOf(const Eigen::MatrixXd& known, Eigen::Index columns) {
  if (known.rows() == 0) return Eigen::MatrixXd::Zero(columns, columns);
  return known.transpose() * known;
}

Eigen::MatrixXd BreadOf(const Sandwich& fit) {
  const Eigen::MatrixXd information =
      fit.rows.transpose() * fit.rows + InformationOf(fit.known, fit.rows.cols());
  return information.completeOrthogonalDecomposition().pseudoInverse();
}

// (1 - H_gg)^-1 e, directions in which it is singular at 1 - h = kLeast.
Eigen::VectorXd WithoutOwnPull(const Eigen::MatrixXd& hat, const Eigen::VectorXd& e) {
  const Eigen::Index size = hat.rows();
  const Modes modes = ModesOf(Eigen::MatrixXd::Identity(size, size) - hat);
  const Eigen::VectorXd inverse = modes.values.cwiseMax(kLeast).cwiseInverse();
  return modes.vectors * inverse.asDiagonal() * (modes.vectors.transpose() * e);
}

}  // namespace

Eigen::MatrixXd SandwichHc3(const Sandwich& fit) {
  std::vector<int> groups(static_cast<std::size_t>(fit.rows.rows()));
  for (std::size_t i = 0; i < groups.size(); ++i) groups[i] = static_cast<int>(i);
  return SandwichByGroup(fit, groups);
}

Eigen::MatrixXd SandwichByGroup(const Sandwich& fit, std::span<const int> groups) {
  Require(fit.rows.rows() == fit.residuals.size(), "as many residuals as rows");
  Require(groups.size() == static_cast<std::size_t>(fit.residuals.size()),
          "as many groups as rows");
  const Eigen::MatrixXd bread = BreadOf(fit);
  Eigen::MatrixXd meat = InformationOf(fit.known, fit.rows.cols());
  const int count = groups.empty() ? 0 : 1 + *std::ranges::max_element(groups);
  std::vector<std::vector<Eigen::Index>> members(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < groups.size(); ++i) {
    members[static_cast<std::size_t>(groups[i])].push_back(
        static_cast<Eigen::Index>(i));
  }
  for (const std::vector<Eigen::Index>& group : members) {
    const auto size = static_cast<Eigen::Index>(group.size());
    Eigen::MatrixXd rows(size, fit.rows.cols());
    Eigen::VectorXd residuals(size);
    for (Eigen::Index k = 0; k < size; ++k) {
      rows.row(k) = fit.rows.row(group[static_cast<std::size_t>(k)]);
      residuals[k] = fit.residuals[group[static_cast<std::size_t>(k)]];
    }
    const Eigen::MatrixXd hat = rows * bread * rows.transpose();
    const Eigen::VectorXd pull = rows.transpose() * WithoutOwnPull(hat, residuals);
    meat += pull * pull.transpose();
  }
  return bread * meat * bread;
}

}  // namespace caltwin
