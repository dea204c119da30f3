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
///
/// `has_places`: false where x and y count places.
std::set<std::int64_t> FactsOfSurface(const std::vector<const Row*>& rows,
                                      const Repeats& repeats,
                                      bool has_places,
                                      Facts* facts);

/// Maps whose heights depend on the sense in which an axis came to the point, by the
/// order in which the points were touched, beside any smooth shape.
void FactsOfArrival(const std::vector<const Row*>& rows, Facts* facts);

/// How several meshes of the same places repeat, where no place was touched twice in
/// one: the noise of a touch from then on. `rows` in the order measured.
void FactsOfMeshes(const std::vector<const Row*>& rows, Repeats* repeats, Facts* facts);

}  // namespace caltwin
