#pragma once

#include <vector>

#include "calibration/facts/repeats.h"

namespace caltwin {

/// Readings of one place that follow a temperature, or two, on a straight line:
///
///   reading = a + k1 T1 (+ k2 T2)
///
/// told where the line leaves a quarter of the readings' spread or less: for the
/// thermometer that it leaves least, and a second one where the rows need it. `also`
/// then names the second, and figures its um/K and how the two go together.
void FactsOfTemperature(const std::vector<const Row*>& rows,
                        const Repeats& repeats,
                        Facts* facts);

}  // namespace caltwin
