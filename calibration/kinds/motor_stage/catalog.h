#pragma once

#include <span>

#include "calibration/procedures/catalog.h"

namespace caltwin {

/// The procedures of motor axes.
std::span<const Procedure> MotorProcedures();

}  // namespace caltwin
