#pragma once

#include <string>

#include "sim/link/gcode.h"

namespace caltwin {

/// What is wrong with the words of a motor controller's command; "" where nothing is.
///
/// Every word must be one that its code has, stand once, and carry what the code wants
/// there: a number, nothing (then an axis is named), or a quoted text. So "Xnan", whose
/// letters would pass for four words without numbers, is refused and not taken for a
/// query. A code that is not in the table has no fault here.
std::string MotorWordFault(const GcodeCommand& command);

}  // namespace caltwin
