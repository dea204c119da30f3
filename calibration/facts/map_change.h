#pragma once

#include <vector>

#include "calibration/facts/repeats.h"

namespace caltwin {

/// What changed between two maps of the same places, where it is a plane and no
/// constant:
///
///   now - before = shift + a u + b v   [u, v from -1/2 to 1/2 over the places]
///
/// Something rigid tilted; the shape is the same. Told where the plane leaves a fifth
/// or less of the changes' spread (of nine places or more, two fifths of their
/// variance), and its tilt is more than readings scatter.
void FactsOfMapChange(const std::vector<const Row*>& rows,
                      const Repeats& repeats,
                      Facts* facts);

}  // namespace caltwin
