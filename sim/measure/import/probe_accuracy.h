#pragma once

#include <string>

#include "sim/measure/import/import.h"

namespace caltwin {

/// Reads repeated touches from a terminal log, as `touch` rows with value = reported z:
/// Klipper's `probe at X,Y is z=Z` and Marlin's `N of M: z: Z` (M48). A line
/// `PROBE_ACCURACY at ...` or `M48 ...` begins a batch, a campaign of its own; a time
/// of day before the reading is kept as t_s. Touches of one place whose height runs
/// away are refused (climb.h).
Imported ReadProbeAccuracy(const std::string& text,
                           const std::string& name,
                           const ImportOptions& options);

}  // namespace caltwin
