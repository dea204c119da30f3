#include "sim/effects/gap_sense.h"

#include <cmath>

namespace caltwin {

Vec3<double> GapSense(const At& at, const Vec3<double>& lost_motion_mm) {
  constexpr double kAlong = 1e-6;
  Vec3<double> sense = at.dir;
  for (int i = 0; i < 3; ++i) {
    const double left_mm = lost_motion_mm[i] - at.compensation_mm[i];
    const double since_mm = at.since_rev_mm[i];
    const bool pushes = at.kind == RowKind::kTouch && std::abs(at.n[i]) > kAlong;
    if (pushes || !Known(since_mm) || since_mm >= left_mm) continue;
    sense[i] *= 2 * since_mm / left_mm - 1;
  }
  return sense;
}

}  // namespace caltwin
