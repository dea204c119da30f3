#pragma once

#include <vector>

#include "calibration/facts/repeats.h"

namespace caltwin {

/// What rounds of levelling say of themselves: by which factor a tilt comes back in the
/// next round. 0 is right; 1: the correction has no effect; 2: it goes to the other
/// motor or the other way; between -1 and 1: a pivot is nearer or further than it is
/// written; beyond: it diverges. With the moves of the motors and their pivots, the
/// pivot itself.
void FactsOfLevelling(const std::vector<const Row*>& rows,
                      const Repeats& repeats,
                      const LevellingLog& levelling,
                      Facts* facts);

}  // namespace caltwin
