#pragma once

#include "calibration/diagnosis/diagnosis.h"

namespace caltwin {

/// Where no model found a cause, one that the numbers amount to by themselves; and
/// where they show something without a cause, that the cause is open.
void NameByFacts(Diagnosis* diagnosis);

}  // namespace caltwin
