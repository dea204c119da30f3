#pragma once

#include "calibration/estimate/uncertain.h"
#include "calibration/loop/session.h"
#include "sim/machine/axis.h"

namespace caltwin {

/// Standard uncertainty of steps/mm nobody has measured, as a fraction: the catalogue's
/// prior.
inline constexpr double kScaleDoubt = 0.01;

/// Commanded millimetres are taken for true ones: the standard uncertainty of their
/// ratio. `unmeasured` of steps/mm that nobody has measured; of those
/// that were, what was found counts as far as it is set.
double ScaleDoubt(Session* session, Axis axis, double unmeasured = kScaleDoubt);

/// True millimetres a commanded one: 1, with that uncertainty. Falls as the steps/mm
/// found rise.
Given ScaleOf(Session* session, Axis axis, double unmeasured = kScaleDoubt);

/// A slope dz/d(along) read in commanded millimetres, its uncertainty widened by what
/// both axes' steps/mm may be off:  slope_true = slope k_z / k_along, so
/// u = |slope| hypot(u_z, u_along).
Uncertain WithScaleDoubt(const Uncertain& slope, const Given& along, const Given& z);

}  // namespace caltwin
