#pragma once

#include <string>

#include "sim/measure/import/import.h"

namespace caltwin {

/// Reads a table of holes measured on a coordinate measuring machine: words apart by
/// blanks, a heading with `Meas X  Meas Y  Nom X  Nom Y` (or MeasX ...) in any order,
/// `Err X  Err Y` to check by, anything else kept; lines above the heading name the
/// plate.
///
/// A hole gives two `position` rows, along x and y, at the nominal place: value =
/// measured - nominal, where the drilling machine went minus where it was sent. How the
/// plate lay on the measuring machine (offset, rotation) is its placement, `setup`.
Imported ReadCmmPlate(const std::string& text,
                      const std::string& name,
                      const ImportOptions& options);

}  // namespace caltwin
