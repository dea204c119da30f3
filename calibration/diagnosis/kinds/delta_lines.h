#pragma once

#include <string_view>
#include <vector>

#include "calibration/diagnosis/diagnosis.h"
#include "calibration/diagnosis/observed.h"
#include "sim/effects/knob_turns.h"
#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/kinds/delta/touch.h"

namespace caltwin {

/// What a line of a delta's baseline turns, by index of kDeltaKnobs and in the knob's
/// unit: its endstops sum to nought, its scale is all three belts', and a tower that
/// stands round (`tower_angle`) turns its carriage's joints along and leaves the
/// effector's as drawn, which is the firmware's angle over `TwistPerAngle` and as much
/// twist; on a machine whose file says nothing of its effector, the firmware's angle.
/// Empty: nothing.
std::vector<KnobTurn<double>> KnobsOfLine(std::string_view name,
                                          double value,
                                          const DeltaDrawing& drawing);

/// A delta as drawn with these lines of its baseline built in.
struct FoundDelta {
  DeltaBuild<double> build{};
  DeltaBed<double> bed{};  ///< As high as it was found where it was touched.
};
FoundDelta DeltaWithBaseline(const Observed& observed,
                             const std::vector<BaselineLine>& lines);

/// The build that the rows of a delta are straight about.
DeltaBuild<double> BelievedBuild(const Observed& observed);

}  // namespace caltwin
