#pragma once

#include "calibration/facts/cells.h"
#include "calibration/facts/fact.h"

namespace caltwin {

/// Whether all rows are sizes of parts: positions without a sense, and no moves.
bool AreSizes(const Rows& rows);

/// Parts of one size along an axis: how much it is too large, which is a scale or a
/// constant: one size does not tell which. Describes, answers nothing.
void FactsOfOneSize(const Rows& rows, Facts* facts);

}  // namespace caltwin
