#pragma once

#include <vector>

#include "calibration/facts/repeats.h"

namespace caltwin {

/// What these rows cannot determine, and the cheapest next measurement with what people
/// own: a feeler gauge, a calliper, a dial, the probe itself, a printed part.
void AddAdvice(const std::vector<const Row*>& rows,
               const Repeats& repeats,
               Facts* facts);

}  // namespace caltwin
