#pragma once

#include "sim/effects/effect.h"
#include "sim/measure/row.h"

namespace caltwin {

/// What a row reads of a nozzle's station, on a machine that is one. Throws InputError
/// where its feature is none of a station's.
void AddStation(const Row& row, const Machine& machine, At* at);

}  // namespace caltwin
