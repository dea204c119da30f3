#pragma once

#include <vector>

#include "calibration/facts/repeats.h"

namespace caltwin {

/// Readings of one place that follow a temperature, up and down on the same line:
///
///   reading = a + k T
///
/// told where the line leaves a tenth of the readings' spread or less, and only for the
/// temperature that it leaves least.
void FactsOfTemperature(const std::vector<const Row*>& rows, Facts* facts);

}  // namespace caltwin
