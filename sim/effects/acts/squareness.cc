#include "sim/base/units.h"
#include "sim/effects/acts/edits.h"

namespace caltwin {

void EditSquareness(const Machine& machine, const Injected& injected, Mjcf* model) {
  const double angle_rad = RadFromMrad(injected.values[0]);
  if (angle_rad == 0) return;
  const Axis turned = injected.axis == "C0Y" ? Axis::kY : Axis::kZ;
  const Axis about = injected.axis == "C0Y"   ? Axis::kZ
                     : injected.axis == "B0Z" ? Axis::kY
                                              : Axis::kX;
  model->TurnAxis(turned, about, angle_rad, machine.axis(turned).mid_mm());
}

void EditRacking(const Machine& machine, const Injected& injected, Mjcf* model) {
  const double angle_rad = RadFromMrad(injected.values[0]);
  if (angle_rad == 0) return;
  model->TurnAxis(Axis::kX, Axis::kZ, angle_rad, machine.axis(Axis::kX).mid_mm());
}

}  // namespace caltwin
