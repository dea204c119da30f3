#pragma once

#include <string>
#include <vector>

#include "sim/measure/import/import.h"

namespace caltwin {

/// What the data of a delta tell beyond their rows, a sentence or two a line: of
/// `klipper-delta` a fit of Klipper's own model beside what was saved, of
/// `klipper-mesh` whether arms or the bed explain what six numbers leave. Empty of
/// other kinds.
std::vector<std::string> ImportAccount(const std::string& kind,
                                       const std::string& text,
                                       const std::string& name,
                                       const ImportOptions& options);

}  // namespace caltwin
