#pragma once

#include "calibration/diagnosis/kinds/diagnosed_kind.h"

namespace caltwin {

/// @name Every kind that is not as a gantry
const DiagnosedKind& DiagnosedDelta();
const DiagnosedKind& DiagnosedTripleZ();
const DiagnosedKind& DiagnosedZStation();
const DiagnosedKind& DiagnosedCoreXy();

}  // namespace caltwin
