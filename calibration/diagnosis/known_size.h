#pragma once

#include "calibration/diagnosis/candidates.h"
#include "calibration/diagnosis/refit.h"

namespace caltwin {

/// Whether the rows tell how large a named cause is: within what is possible, twice its
/// standard deviation at least, no ten times the usual where it is what a kelvin does,
/// and of a growth, that they see it level off.
bool IsSizeKnown(const Candidate& candidate, const Refined& refined);

}  // namespace caltwin
