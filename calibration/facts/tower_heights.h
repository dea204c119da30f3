#pragma once

#include <vector>

#include "calibration/facts/fact.h"

namespace caltwin {

/// What a delta's seven heights say once its endstops and radius are set: centre and
/// towers at 0, the places across from the towers (features "delta.ox" ...) not. Their
/// mean is what all towers share, rods of another length beside that radius, or
/// steps/mm; what is left is one tower's:
///
///   (-1/2, -1/2, 1)   the tower stands out or in, or its rods are of another length
///   (1, -1, 0)        the third tower's angle
void FactsOfTowerHeights(const std::vector<const Row*>& rows, Facts* facts);

}  // namespace caltwin
