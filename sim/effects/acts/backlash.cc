#include "sim/effects/acts/edits.h"
#include "sim/effects/drive.h"

namespace caltwin {

// Friction acts between carriage and rail, never on the play: there it would glue the
// carriage to the nut and the gap would never show.
void EditBacklash(const Machine&, const Injected& injected, Mjcf* model) {
  model->SetGap(kAxes[DriveNamed(injected.axis).value().slot()], injected.values[0]);
}

}  // namespace caltwin
