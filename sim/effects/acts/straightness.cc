#include "sim/effects/straightness.h"

#include "sim/base/units.h"
#include "sim/effects/acts/edits.h"

namespace caltwin {

void EditStraightness(const Machine& machine, const Injected& injected, Mjcf* model) {
  if (injected.values[0] == 0) return;
  const Axis moving = MovingAxis(injected.axis);
  model->BendRail(moving,
                  Straightness::Across(injected.axis),
                  MmFromUm(injected.values[0]),
                  machine.axis(moving));
}

// The ends of the beam stand higher than its middle.
void EditGantrySag(const Machine& machine, const Injected& injected, Mjcf* model) {
  if (injected.values[0] == 0) return;
  model->BendRail(
      Axis::kX, Axis::kZ, MmFromUm(injected.values[0]), machine.axis(Axis::kX));
}

}  // namespace caltwin
