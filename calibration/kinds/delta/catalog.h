#pragma once

#include <span>

#include "calibration/procedures/catalog.h"

namespace caltwin {

/// The procedures of a delta.
std::span<const Procedure> DeltaProcedures();

}  // namespace caltwin
