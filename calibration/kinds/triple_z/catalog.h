#pragma once

#include <span>

#include "calibration/procedures/catalog.h"

namespace caltwin {

/// The procedures of a bed on three screws.
std::span<const Procedure> TripleZProcedures();

}  // namespace caltwin
