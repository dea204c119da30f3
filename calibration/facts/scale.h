#pragma once

#include <cstddef>

#include "calibration/facts/fact.h"
#include "calibration/facts/motion_line.h"

namespace caltwin {

/// What the line through readings of one axis says of its steps/mm: a constant that all
/// sizes have too much or too little, a constant beside a scale, a scale (and what
/// steps/mm it needs, a ratio that people know), what each move loses. `noise_mm` of
/// one reading; kUnknown: nothing shows it. `steps_per_mm` that were set; kUnknown.
void FactsOfLine(const Line& line,
                 double noise_mm,
                 std::size_t axis,
                 double steps_per_mm,
                 Facts* facts);

/// Of scales of one axis against which nothing speaks the surest alone: the same said
/// of several campaigns tells a reader nothing more.
void KeepSurestScales(Facts* facts);

}  // namespace caltwin
