#pragma once

#include <string>

#include "calibration/estimate/uncertain.h"
#include "calibration/loop/session.h"

namespace caltwin {

/// What is left of a gap by an instrument that is not the motors' counter: led in to +
/// and zeroed, on in +, back to the same command; positive: lost motion.
Expected<Uncertain> ReadGapLeft(Session* session,
                                Axis axis,
                                const std::string& instrument,
                                int repeats);

}  // namespace caltwin
