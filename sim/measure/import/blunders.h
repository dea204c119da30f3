#pragma once

#include <string>
#include <vector>

#include "sim/measure/import/import.h"

namespace caltwin {

/// Throws InputError where a file holds one of the mistakes that people are known to
/// have made and that firmware swallowed, each told with what it is and what to do:
///
/// - the same list of readings pasted under two names (Klipper issue 4755);
/// - a probed height that climbs with every touch at one place (Klipper issue 3196);
/// - a levelling adjustment of metres from a difference of micrometres (Klipper 2903);
/// - a probe offset of the wrong sign under a saved delta calibration (Klipper 775);
/// - a standard deviation below nought (Marlin issue 7402).
///
/// Looked for in every text whatever its kind, since it is a person's guess which kind
/// a log is.
void RefuseBlunders(const std::string& text, const std::string& name);

/// The same as notes: why it is not the machine, or which setting is wrong.
std::vector<FileNote> BlundersIn(const std::string& text, const std::string& name);

}  // namespace caltwin
