#pragma once

#include <cmath>
#include <numbers>

#include "sim/base/units.h"
#include "sim/effects/effect.h"

namespace caltwin {

/// Where a touched point lies on the plate, in the plate's own frame: from the middle
/// of the travel, turned back by `artefact_turn_deg`, -1 .. 1 over the travel. Of the
/// plate's own axes: a plate turned by 90 degrees takes its shape along. On a round bed
/// the rim (of the outermost touch) is where a square's corners would be.
template <typename T>
Eigen::Matrix<T, 2, 1> OnPlate(const Asked<T>& asked) {
  if (asked.at.rim_mm > 0) {
    const double edge_mm = asked.at.rim_mm / std::numbers::sqrt2;
    return Vec3<T>(asked.q_mm + asked.at.probe_off_mm.template cast<T>())
               .template head<2>() /
           T(edge_mm);
  }
  const AxisDrawing& x = asked.machine.axis(Axis::kX);
  const AxisDrawing& y = asked.machine.axis(Axis::kY);
  const double turn_rad = RadFromDeg(asked.at.artefact_turn_deg);
  const T dx_mm = asked.q_mm[0] + asked.at.probe_off_mm[0] - x.mid_mm();
  const T dy_mm = asked.q_mm[1] + asked.at.probe_off_mm[1] - y.mid_mm();
  const double c = std::cos(turn_rad);
  const double s = std::sin(turn_rad);
  return {(c * dx_mm + s * dy_mm) / (x.travel_mm() / 2),
          (c * dy_mm - s * dx_mm) / (y.travel_mm() / 2)};
}

/// Raises the table's surface there; side faces do not feel it.
template <typename T>
void AddHeight(const Asked<T>& asked, const T& height_mm, Errors<T>* errors) {
  if (asked.at.on_table) errors->artefact_mm += asked.at.n[2] * height_mm;
}

}  // namespace caltwin
