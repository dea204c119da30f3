#pragma once

#include "calibration/procedures/catalog.h"

namespace caltwin {

/// Two public replacements for NeXT's phase 3 whose difference holds no backlash: both
/// approaches end in the same sense, so two reversals cancel. Corrected: trigger
/// against release, and the dial led in and brought back.
extern const Procedure kSameSideBacklash;
extern const Procedure kAwayReturnBacklash;

}  // namespace caltwin
