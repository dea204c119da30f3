#include "sim/base/units.h"
#include "sim/effects/acts/edits.h"
#include "sim/effects/drive.h"

namespace caltwin {

// Lost motion F c at a reversal from +F to -F: a spring of stiffness 2 / c.
void EditWindupLoad(const Machine&, const Injected& injected, Mjcf* model) {
  const double compliance_mm_per_n = MmFromUm(injected.values[0]);
  if (compliance_mm_per_n == 0) return;
  model->SetDriveStiffness(kAxes[DriveNamed(injected.axis).value().slot()],
                           2.0 / compliance_mm_per_n);
}

}  // namespace caltwin
