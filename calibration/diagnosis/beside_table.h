#pragma once

#include <cstddef>
#include <vector>

#include "calibration/diagnosis/found.h"
#include "calibration/diagnosis/weighing.h"

namespace caltwin {

/// Whether a free form stands for itself and for a name found beside it, being what the
/// name deviates by from its own form. All of these hold:
///  - both are seen in the same rows and vary with the same thing;
///  - the form carries more than 0.6 of what the name does, either with the other in
///    place (root of what the residual sum of squares rises by without it), or is more
///    than 0.6 as tall in the same channel;
///  - the form can take at least a tenth of the name's squares: of a wave finer than
///  its
///    terms, where the rows show it as such, it can take nothing, and both are there.
///
/// @param baseline     with nothing that was found
/// @param free, named  of `found`
bool StandsForBoth(const Observed& observed,
                   const std::vector<Candidate>& candidates,
                   const Circumstances& baseline,
                   const std::vector<Found>& found,
                   std::size_t free,
                   std::size_t named);

}  // namespace caltwin
