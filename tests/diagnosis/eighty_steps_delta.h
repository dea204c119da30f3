#pragma once

#include "sim/machine/kinds/delta/drawing.h"
#include "sim/machine/kinds/kinds.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// A delta with 80 steps/mm in each tower, geometry and probe as a drawing has them.
inline Machine EightyStepsDelta() {
  Machine machine{.kind = DeltaKind(), .own = DeltaDrawing{}};
  for (AxisDrawing& tower : machine.axes) {
    tower.lead_mm = 40;
    tower.is_belt = true;
    tower.full_steps_per_rev = 200;
    tower.microsteps = 16;
  }
  return machine;
}

}  // namespace caltwin
