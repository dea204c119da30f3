#pragma once

#include <array>

#include <Eigen/Core>

namespace caltwin {

/// `gantry: {corners_mm: [[-60, -10], [360, 370]]}` of a CoreXY whose gantry hangs on a
/// motor of Z at each corner of that rectangle, over a bed that stands: z at the first
/// corner, then clockwise seen from above (low x and high y; high both; high x).
///
/// The gantry twists as they come apart: over (x, y) it is as high as
///
///   sum w_i(x, y) height_i,   w bilinear: 1 at its own corner, 0 at the others   [mm]
struct CornersDrawing {
  static constexpr int kNum = 4;
  Eigen::Vector2d low_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d high_mm = Eigen::Vector2d::Zero();

  Eigen::Vector4d Weights(double x_mm, double y_mm) const {
    const double u = (x_mm - low_mm[0]) / (high_mm[0] - low_mm[0]);
    const double v = (y_mm - low_mm[1]) / (high_mm[1] - low_mm[1]);
    return {(1 - u) * (1 - v), (1 - u) * v, u * v, u * (1 - v)};
  }
};

}  // namespace caltwin
