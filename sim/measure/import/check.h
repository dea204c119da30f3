#pragma once

#include <string>

#include "sim/measure/row.h"

namespace caltwin {

/// Throws InputError where a row holds what a file of measured rows may not: a number
/// beyond its column's bounds, a length beyond a kilometre, a campaign without a name.
/// Each fault is at the place in the file that was read.
void CheckImported(const RowTable& table);

}  // namespace caltwin
