#include "sim/machine/screw_levelling.h"

#include <cmath>

#include <Eigen/LU>

#include "sim/machine/kinds/triple_z/drawing.h"

namespace caltwin {
namespace {

struct Spread {
  double mean = 0, deviation = 0;
};

Spread SpreadOf(const Eigen::VectorXd& values) {
  const double mean = values.mean();
  return {mean, std::sqrt((values.array() - mean).square().mean())};
}

}  // namespace

std::optional<ScrewCorrections> LevelScrews(const Pivots<double>& pivots_mm,
                                            std::span<const BedTouch> touches) {
  constexpr double kDependent = 1e-9;
  const auto n = static_cast<Eigen::Index>(touches.size());
  Eigen::MatrixX3d weights(n, 3);
  Eigen::VectorXd heights_mm(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const BedTouch& touch = touches[static_cast<std::size_t>(k)];
    weights.row(k) =
        ScrewWeights<double>(pivots_mm, touch.at_mm[0], touch.at_mm[1]).transpose();
    heights_mm[k] = touch.height_mm;
  }
  const Eigen::Matrix3d normal = weights.transpose() * weights;
  if (n < 3 || std::abs(normal.determinant()) < kDependent) return std::nullopt;
  ScrewCorrections corrections{.raise_mm = -normal.inverse() *
                                           (weights.transpose() * heights_mm)};
  const Spread before = SpreadOf(heights_mm);
  const Spread after = SpreadOf(heights_mm + weights * corrections.raise_mm);
  corrections.mean_before_mm = before.mean;
  corrections.deviation_before_mm = before.deviation;
  corrections.mean_after_mm = after.mean;
  corrections.deviation_after_mm = after.deviation;
  return corrections;
}

}  // namespace caltwin
