#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/kinds/delta/touch.h"

namespace caltwin {

/// A mesh of heights as printer firmwares hold one: nodes on a square over the bed,
/// bilinear between them. What is commanded at (x, y) is lifted by it at every height.
struct DeltaMesh {
  double radius_mm = 100;           ///< The square reaches so far along x and y.
  int nodes = 0;                    ///< Along each side; 0: there is none.
  std::vector<double> height_mm{};  ///< Row by row from -y, each from -x.

  /// Where a node stands along either axis [mm].
  double Node_mm(int index) const {
    return radius_mm * (2.0 * index / (nodes - 1) - 1);
  }
  double At(int column, int row) const {
    const auto of = [](int count) {
      return static_cast<std::size_t>(count);
    };
    return height_mm[of(row) * of(nodes) + of(column)];
  }
  /// Beyond the square as at its rim.
  double Lift_mm(double x_mm, double y_mm) const {
    if (nodes < 2) return 0;
    const double cells = nodes - 1;
    const double u = std::clamp((x_mm / radius_mm + 1) / 2 * cells, 0.0, cells);
    const double v = std::clamp((y_mm / radius_mm + 1) / 2 * cells, 0.0, cells);
    const int i = std::min(static_cast<int>(u), nodes - 2);
    const int j = std::min(static_cast<int>(v), nodes - 2);
    const double s = u - i, t = v - j;
    return (1 - s) * (1 - t) * At(i, j) + s * (1 - t) * At(i + 1, j) +
           (1 - s) * t * At(i, j + 1) + s * t * At(i + 1, j + 1);
  }
};

/// Where a machine's nozzle is at these commanded travels; nullopt: out of reach.
using NozzleOfMotors =
    std::function<std::optional<Vec3<double>>(const Vec3<double>& motors_mm)>;

/// DeltaAccuracyOf of a machine that is more than a chain (its carriages have play).
DeltaAccuracy DeltaAccuracyOf(const NozzleOfMotors& nozzle_of,
                              const DeltaBed<double>& bed,
                              const DeltaModel<double>& settings,
                              double radius_mm,
                              const DeltaMesh& mesh);

/// DeltaAccuracyOf of a firmware that lifts by a mesh beside its settings.
DeltaAccuracy DeltaAccuracyOf(const DeltaBuild<double>& build,
                              const DeltaBed<double>& bed,
                              const DeltaModel<double>& settings,
                              double radius_mm,
                              const DeltaMesh& mesh);

}  // namespace caltwin
