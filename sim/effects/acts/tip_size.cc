#include "sim/effects/acts/edits.h"

namespace caltwin {

void EditTipSize(const Machine& machine, const Injected& injected, Mjcf* model) {
  if (injected.values[0] == 0) return;
  model->SetTipRadius(machine.probe.tip_radius_mm + injected.values[0]);
}

}  // namespace caltwin
