#pragma once

#include <string>

#include "calibration/diagnosis/diagnosis.h"

namespace caltwin {

/// What to say of lost steps on an axis of a gantry whose size is no whole number of
/// electrical turns (4 full steps), by which a motor slips: a block that was pushed or
/// a gauge that was set anew looks the same. Empty where the size is whole as far as
/// its standard deviation tells, and of other findings.
std::string RemarkOnJump(const Machine& machine, const Finding& finding);

}  // namespace caltwin
