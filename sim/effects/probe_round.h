#pragma once

#include <cmath>

#include "sim/base/units.h"
#include "sim/effects/effect.h"

namespace caltwin {

/// The pre-travel varies with the direction of the touch about the spindle, `lobes`
/// times around:
///
///   more pre-travel = A cos(lobes (theta - spindle) + phase) h   [mm]
///
/// theta the direction of the outward normal seen from above, h = sqrt(nx^2 + ny^2), so
/// that a touch straight down does not feel it.
template <typename T>
void AddLobes(const Asked<T>& asked,
              double lobes,
              const T& amplitude_um,
              const T& phase_deg,
              Errors<T>* errors) {
  using std::cos;
  const At& at = asked.at;
  const double level = std::hypot(at.n[0], at.n[1]);
  if (at.kind != RowKind::kTouch || level == 0) return;
  const double theta_rad =
      std::atan2(at.n[1], at.n[0]) - RadFromDeg(at.probe_angle_deg);
  errors->more_pretravel_mm +=
      MmFromUm(amplitude_um) * level * cos(lobes * theta_rad + RadFromDeg(phase_deg));
}

}  // namespace caltwin
