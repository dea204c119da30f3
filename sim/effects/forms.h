#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "sim/base/units.h"
#include "sim/effects/effect.h"

namespace caltwin {

/// What several closed forms share, and the grids on which diagnosis seeks the
/// parameters that change an effect's shape (Sight::forms).

/// A sin(2 pi q / period + phase) [mm].
template <typename T>
T Wave_mm(const T& amplitude_um,
          const T& phase_deg,
          const T& q_mm,
          const T& period_mm) {
  using std::sin;
  const T turns = q_mm / period_mm;
  return MmFromUm(amplitude_um) *
         sin(2 * std::numbers::pi * turns + RadFromDeg(phase_deg));
}

/// One entry for each value of a single form parameter.
using Forms = std::vector<std::vector<double>>;
Forms OfOne(const std::vector<double>& values);

/// `count` values from first to last, each the same factor beyond the one before.
std::vector<double> Geometric(double first, double last, int count);

/// How far rows reach along an axis [mm].
double Span_mm(const Extent& extent, Axis axis);

/// The same of a drive by name, a tower's or screw's along its motor.
double DriveSpan_mm(const Extent& extent, std::string_view name);

/// Periods within 3 % of the drawn one, so close that between neighbours the phase at
/// the ends of the span moves by at most a quarter of a turn. No more than 25: over
/// more than 200 periods they reach less far. None where the span is below a quarter of
/// a period: there a wave is a line.
std::vector<double> Periods_mm(double drawn_mm, double span_mm);

/// Lags of a part behind its thermometer: 0, then 50 s doubled up to 6400 s or three
/// times the rows' duration, whichever is less.
std::vector<double> Lags_s(const Extent& extent);

/// Time constants of a growth: 1/20 to 3 times the rows' duration. None where the rows
/// know no two times.
std::vector<double> TimeConstants_s(const Extent& extent);

/// Moments of a jump: between every two neighbouring rows, or, of 200 and more, 200 of
/// them evenly chosen.
std::vector<double> JumpTimes_s(const Extent& extent);

}  // namespace caltwin
