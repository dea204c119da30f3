#pragma once

#include <optional>
#include <span>

#include "sim/machine/kinds/triple_z/drawing.h"

namespace caltwin {

/// TriangleShape of screws that still hold a bed level; flatter ones are refused.
inline constexpr double kFlattestTriangle = 0.05;

/// The bed touched at one place: its height over where the nozzle's zero is, + higher.
struct BedTouch {
  Eigen::Vector2d at_mm = Eigen::Vector2d::Zero();
  double height_mm = 0;
};

/// How a controller levels a bed by its screws, as it believes them to stand.
struct ScrewCorrections {
  Vec3<double> raise_mm = Vec3<double>::Zero();        ///< Each screw, + lifts the bed.
  double mean_before_mm = 0, deviation_before_mm = 0;  ///< Of the touched heights.
  double mean_after_mm = 0, deviation_after_mm = 0;    ///< As it expects them.
};

/// Least squares of  height_k + sum w_i(x_k, y_k) raise_i = 0, w_i the believed screws'
/// weights. nullopt with fewer than three touches, or with touches on one line.
std::optional<ScrewCorrections> LevelScrews(const Pivots<double>& pivots_mm,
                                            std::span<const BedTouch> touches);

}  // namespace caltwin
