#pragma once

#include <string_view>
#include <vector>

#include "sim/effects/knob_turns.h"

namespace caltwin {

/// What a line of a delta's baseline turns, by index of kDeltaKnobs and in the knob's
/// unit: its endstops sum to nought, its scale is all three belts'. Empty: nothing.
std::vector<KnobTurn<double>> KnobsOfLine(std::string_view name, double value);

}  // namespace caltwin
