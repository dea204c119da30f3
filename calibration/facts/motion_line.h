#pragma once

#include <cmath>
#include <cstddef>

#include "calibration/facts/levels.h"
#include "calibration/facts/repeats.h"

namespace caltwin {

/// Readings against command along one axis: value = a + slope q - gap sense / 2.
struct Line {
  double offset_mm = 0, slope = 0, gap_mm = 0;
  double offset_unit_sd = 0, slope_unit_sd = 0,
         gap_unit_sd = 0;                           ///< For a noise of 1 mm.
  double least_mm = HUGE_VAL, most_mm = -HUGE_VAL;  ///< Of positions.
  bool has_senses_unknown = false, are_moves = false;
  bool are_parts = false;  ///< Sizes of parts, which shrink.
  double left_mm2 = 0, dof = 0;
  bool has_gap = false, has_slope = false;
};

/// The line through readings of one axis that turn round far enough to take up the gap
/// in full, where that fits twice as well; else through all. dof < 0: nothing to fit.
Line FitBeyondGap(const Rows& rows, std::size_t axis);

/// The larger of what repeats show and what the line leaves; kUnknown of neither, and
/// of readings that lie on the line to their last digit.
double NoiseOf_mm(const Line& line, const ReadingNoise& noise);

}  // namespace caltwin
