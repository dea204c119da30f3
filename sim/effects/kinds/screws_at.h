#pragma once

#include "sim/effects/effect.h"
#include "sim/measure/row.h"

namespace caltwin {

/// Where a bed's screws stand by what the row tells of them, on machines that have
/// some.
void AddScrews(const Row& row, const Machine& machine, At* at);

}  // namespace caltwin
