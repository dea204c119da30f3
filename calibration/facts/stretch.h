#pragma once

#include <vector>

#include "calibration/facts/repeats.h"

namespace caltwin {

/// An axis that is right but for one stretch of its travel, in which it goes further or
/// less far than it is told:
///
///   deviation = e0 up to a,  rising evenly to e1 at b,  e1 from b on
///
/// No steps/mm does that: the scale that a line through all would give is taken back.
/// Told where this leaves a quarter or less of what a line leaves, of six places or
/// more, three of them outside.
///
/// And heights that are off by so much a millimetre up to one place and by a constant
/// from there on: what is faded out, a levelling mesh, does that.
void FactsOfStretch(const std::vector<const Row*>& rows,
                    const Repeats& repeats,
                    Facts* facts);

}  // namespace caltwin
