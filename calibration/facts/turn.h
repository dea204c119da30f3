#pragma once

#include <vector>

#include "calibration/facts/fact.h"

namespace caltwin {

/// Moves in a plane that were read in that plane: whether what moved is the command
/// turned, mirrored or with its axes exchanged,
///
///   read = A commanded, A near a turn by 30, 45, 60, 90, 120 or 180 degrees, or a
///   mirror
///
/// Rows that one line of a table gave (Row::place) belong together.
void FactsOfTurn(const std::vector<const Row*>& rows, Facts* facts);

}  // namespace caltwin
