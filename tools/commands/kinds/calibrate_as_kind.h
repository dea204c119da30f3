#pragma once

#include <optional>

#include "tools/commands/calibrate.h"

namespace caltwin {

/// `caltwin calibrate` of what is no gantry: its exit code. nullopt: it is one.
std::optional<int> CalibrateAsKind(const CalibrateOptions& options);

}  // namespace caltwin
