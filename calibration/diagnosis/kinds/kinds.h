#pragma once

#include "calibration/diagnosis/kinds/diagnosed_kind.h"

namespace caltwin {

/// @name Every kind that is not as a gantry
const DiagnosedKind& DiagnosedDelta();
const DiagnosedKind& DiagnosedTripleZ();
const DiagnosedKind& DiagnosedZStation();
const DiagnosedKind& DiagnosedCoreXy();
const DiagnosedKind& DiagnosedCoreXyOnScrews();

/// Scale and backlash that all screws of a bed share; like a gantry's z.
void AddScrews(const Observed& o, NuisanceList* list);

}  // namespace caltwin
