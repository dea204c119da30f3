#pragma once

#include <set>
#include <vector>

#include "calibration/facts/repeats.h"

namespace caltwin {

/// What touched heights of a bed or table say: far-off touches (a robust start: they
/// may hide each other), tilt, twist of its corners, and the shape that a plane leaves.
///
///   height = a + b u + c v + twist u v + ..., u and v from -1 to 1 over the places
///
/// @return running numbers of rows that are far off
std::set<std::int64_t> FactsOfSurface(const std::vector<const Row*>& rows,
                                      const Repeats& repeats,
                                      Facts* facts);

}  // namespace caltwin
