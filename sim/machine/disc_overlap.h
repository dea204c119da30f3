#pragma once

#include <Eigen/Core>

namespace caltwin {

/// A flat disc over (or under) a flat rectangular face, seen from above.
struct DiscOverFace {
  Eigen::Vector2d disc_mm{0, 0};  ///< Centre of the disc.
  double radius_mm = 1;
  Eigen::Vector2d face_mm{0, 0};  ///< Centre of the face, its sides along x and y.
  Eigen::Vector2d half_mm{1, 1};
};

/// Where a tilted face touches the disc first: the point of their overlap farthest
/// along `uphill` (the direction in which the face comes nearer). With a slope s the
/// disc so touches up to radius * |s| early: 6 um for 6 mm and 1 mrad. The nearest
/// point of the face to the disc's centre where they do not overlap.
Eigen::Vector2d FirstContact_mm(const DiscOverFace& faces,
                                const Eigen::Vector2d& uphill);

}  // namespace caltwin
