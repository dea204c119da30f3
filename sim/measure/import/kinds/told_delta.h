#pragma once

#include <string>

#include "sim/measure/import/import.h"

namespace caltwin {

/// Where a text has touches of a bed, speaks of a delta and does not say its geometry:
/// causes of a gantry are none of such a machine, and which of its towers errs takes
/// its rods and radius. Says so, and what to hand in.
void TellOfDelta(const std::string& text, Imported* imported);

}  // namespace caltwin
