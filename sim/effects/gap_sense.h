#pragma once

#include "sim/effects/effect.h"

namespace caltwin {

/// `at.dir`, of an axis that has not yet crossed its gap since it turned round as much
/// of it as it has: -1 where it has only just turned, 1 once the nut pushes again,
/// times the sense. With d the travel since the reversal, b the lost motion and c what
/// the firmware put in for it at the reversal,
///
///   dir clamp(2 d / (b - c) - 1, -1, 1),
///
/// so that the carriage, -dir (b - c) / 2, stands still while d grows from 0 to b - c.
/// Unchanged where d is not known, and along n of a touch: what touches, pushes.
Vec3<double> GapSense(const At& at, const Vec3<double>& lost_motion_mm);

}  // namespace caltwin
