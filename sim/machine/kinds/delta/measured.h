#pragma once

#include "sim/base/units.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/kinds/delta/touch.h"

namespace caltwin {

/// @name The delta on which public engines' own code was measured elsewhere
/// (docs/delta-engines.md): what it is built as, what its firmware starts with, and the
/// bed of its tilted rows. Radius of the disc judged: 100 mm.
inline DeltaModel<double> MeasuredDeltaAsDrawn() {
  return SymmetricDelta(300, 130, 250);
}
inline DeltaBuild<double> MeasuredDelta(double arm_mm = 250) {
  DeltaBuild<double> build{.model = SymmetricDelta(300, 130.8, arm_mm)};
  build.model.angle_rad[0] += RadFromDeg(0.35);
  build.model.angle_rad[1] -= RadFromDeg(0.25);
  build.model.endstop_mm = {300.30, 299.80, 300.45};
  return build;
}
inline DeltaBed<double> MeasuredDeltaTilted() {
  return {.slope_x = 0.002, .slope_y = -0.001};
}

}  // namespace caltwin
