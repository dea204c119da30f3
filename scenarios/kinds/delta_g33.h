#pragma once

#include "calibration/kinds/delta/bench.h"
#include "calibration/kinds/delta/g33.h"
#include "sim/kinds/delta/twin.h"

namespace caltwin {

/// Marlin's G33, as published or corrected, for a simulated controller of a delta with
/// that bed.
G33Program MarlinG33(G33Variant variant, double print_radius_mm);

/// The simulated person's calliper. Borrows the twin.
DeltaCalliper CalliperOf(DeltaTwin* twin);

}  // namespace caltwin
