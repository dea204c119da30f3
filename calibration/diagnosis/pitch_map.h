#pragma once

#include "calibration/diagnosis/candidates.h"
#include "calibration/diagnosis/gain.h"

namespace caltwin {

/// Whether a free form in an axis' own position may be called its `pitch_map`: the
/// positions must be able to tell it from the waves of screw, pulley and full steps
/// (random offsets, or 2.5 positions a period), and at least 80 % of its gain with runs
/// left out must hold with interior positions left out.
bool IsPitchMap(const Observed& observed,
                const Candidate& candidate,
                const GainFigures& gain);

}  // namespace caltwin
