#pragma once

#include "sim/measure/import/import.h"

namespace caltwin {

/// Reads a screw's compensation table: what it corrects, as rows of the kind position.
///
///   LinuxCNC `.comp`  NOMINAL FORWARD REVERSE: positions read (COMP_FILE_TYPE 0), or
///                     corrections to be added (type 1): error = -correction. Type 1
///                     where both columns are small against the nominal's travel
///   Centroid `.tab`   header, then a correction or two a line; only its version 3 says
///                     what its counts are
Imported ReadScrewTable(const std::string& text,
                        const std::string& name,
                        const ImportOptions& options);

}  // namespace caltwin
