#pragma once

#include <optional>

#include "calibration/procedures/catalog.h"
#include "calibration/procedures/options.h"

namespace caltwin {

struct DeflectionOptions {
  CommonOptions common{};
  double size_mm = 25.4;  ///< Of a block; other artefacts have only one.
  /// What is left of the gap after compensation; none: from what was measured before.
  std::optional<Given> backlash_left_mm{};
  /// Of the ball; none: from a calliper where there is one, else as entered.
  std::optional<Given> tip_radius_mm{};
};

/// NeXT phase 4: pre-travel of the probe along one axis from one size.
Expected<void> RunDeflection(Session* session, const DeflectionOptions& options);

extern const Procedure kDeflection;

}  // namespace caltwin
