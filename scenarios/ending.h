#pragma once

#include "calibration/loop/outcome.h"
#include "sim/link/link.h"

namespace caltwin {

/// How a run that met this fault ended.
Ending EndingOf(const MachineFault& fault);

}  // namespace caltwin
