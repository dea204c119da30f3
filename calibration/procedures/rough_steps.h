#pragma once

#include <string>

#include "calibration/procedures/catalog.h"
#include "calibration/procedures/options.h"

namespace caltwin {

struct RoughOptions {
  CommonOptions common{};
  double distance_mm = 100;  ///< Commanded; of z at most what its travel allows.
  std::string instrument = "laser";  ///< laser | dial
};

/// NeXT phase 1: steps/mm from one long move read by an instrument.
Expected<void> RunRoughSteps(Session* session, const RoughOptions& options);

extern const Procedure kRoughSteps;

}  // namespace caltwin
