#include "calibration/estimate/tilt_plane.h"

#include <algorithm>
#include <cmath>

#include "calibration/estimate/linear_fit.h"
#include "sim/base/require.h"

namespace caltwin {
namespace {

// A plane is determined where its slopes are better known than 1 mm per mm of the
// points' own extent; collinear points leave one slope free.
constexpr double kRelativeRank = 1e-6;

}  // namespace

TiltPlane FitTiltPlane(std::span<const Vec3<double>> points_mm,
                       double sigma_mm,
                       const Vec3<double>& about_mm) {
  Require(sigma_mm > 0, "a touch has a standard deviation");
  if (points_mm.empty()) return {};

  // About the centroid and in units of the extent, so that the columns are alike.
  Vec3<double> centre_mm = Vec3<double>::Zero();
  for (const Vec3<double>& p : points_mm) centre_mm += p;
  centre_mm /= static_cast<double>(points_mm.size());
  double extent_mm = 0;
  for (const Vec3<double>& p : points_mm) {
    extent_mm = std::max(extent_mm, (p - centre_mm).head<2>().norm());
  }
  if (extent_mm == 0) extent_mm = 1;

  Eigen::MatrixXd a(points_mm.size(), 3);
  Eigen::VectorXd r(points_mm.size());
  for (Eigen::Index row = 0; const Vec3<double>& p : points_mm) {
    const Vec3<double> u = (p - centre_mm) / extent_mm;
    a.row(row) << 1, u.x(), u.y();
    a.row(row) /= sigma_mm;
    r[row++] = (p.z() - centre_mm.z()) / sigma_mm;
  }
  const LinearFit fit = SolveLinear(a, r, {.relative = kRelativeRank});

  TiltPlane plane;
  const auto combine = [&](const Eigen::Vector3d& weights, double offset) -> Uncertain {
    return {.value = offset + weights.dot(fit.x),
            .sd = SdOf(weights, fit.covariance),
            .identifiable = fit.identifiable};
  };
  const Vec3<double> to = (about_mm - centre_mm) / extent_mm;
  plane.height_mm = combine({1, to.x(), to.y()}, centre_mm.z());
  plane.slope_x = combine({0, 1 / extent_mm, 0}, 0);
  plane.slope_y = combine({0, 0, 1 / extent_mm}, 0);
  if (fit.identifiable) {
    plane.slope_covariance = fit.covariance(1, 2) / (extent_mm * extent_mm);
  }
  plane.dof = fit.dof;
  plane.chi2_per_dof = fit.chi2_per_dof;
  double squares = 0;
  for (const double residual : fit.residuals) {
    plane.residuals_mm.push_back(residual * sigma_mm);
    plane.worst_mm = std::max(plane.worst_mm, std::abs(residual) * sigma_mm);
    squares += residual * residual * sigma_mm * sigma_mm;
  }
  plane.rms_mm = std::sqrt(squares / static_cast<double>(points_mm.size()));
  return plane;
}

}  // namespace caltwin
