#pragma once

#include <cmath>

#include "sim/effects/effect.h"

namespace caltwin {

/// The velocity at which a ball-bar's tip runs round its circle [mm/s], machine axes:
/// tangent to the outward normal, in the sense that the axes' last moves tell. Zero for
/// any other row, and where the sense is not known.
inline Vec3<double> CirclingVelocity_mm_s(const At& at) {
  if (at.kind != RowKind::kRadial) return Vec3<double>::Zero();
  const Vec3<double> counter_clockwise(-at.n[1], at.n[0], 0);
  const double along = counter_clockwise.dot(at.dir);
  const double sense = along > 0 ? 1 : along < 0 ? -1 : 0;
  return sense * at.feed_mm_s * counter_clockwise;
}

}  // namespace caltwin
