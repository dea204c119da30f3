#pragma once

#include <vector>

#include "calibration/facts/repeats.h"

namespace caltwin {

/// Readings close together along one axis that go up and down in a wave whose period
/// and size drift (sim/base/drifting_wave.h): nothing that turns with the axis does
/// that. Waves of one period have causes, which the diagnosis weighs.
void FactsOfWaves(const std::vector<const Row*>& rows,
                  const Repeats& repeats,
                  Facts* facts);

}  // namespace caltwin
