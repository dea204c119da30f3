#include "sim/base/units.h"
#include "sim/effects/acts/edits.h"

namespace caltwin {

void EditBedTilt(const Machine& machine, const Injected& injected, Mjcf* model) {
  if (injected.values[0] == 0 && injected.values[1] == 0) return;
  model->TiltTable(
      RadFromMrad(injected.values[0]),
      RadFromMrad(injected.values[1]),
      {machine.axis(Axis::kX).mid_mm(), machine.axis(Axis::kY).mid_mm(), 0});
}

}  // namespace caltwin
