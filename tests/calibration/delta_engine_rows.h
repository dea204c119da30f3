#pragma once

// The machine on which public engines were measured elsewhere, and how far a
// calibration leaves it from the truth.

#include <cmath>
#include <cstddef>

#include "calibration/kinds/delta/bench.h"
#include "sim/base/units.h"
#include "sim/machine/kinds/delta/measured.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/kinds/delta/simulated.h"

namespace caltwin::delta_rows {

inline DeltaModel<double> Believed() {
  return MeasuredDeltaAsDrawn();
}

inline DeltaBuild<double> Built(double arm_mm = 250) {
  return MeasuredDelta(arm_mm);
}

inline DeltaBed<double> Tilted() {
  return MeasuredDeltaTilted();
}

/// Touches `machine`, which must outlive it.
inline DeltaProbe ProbeOf(SimulatedDelta* machine) {
  return [machine](const DeltaModel<double>& settings, double x_mm, double y_mm) {
    return machine->Touch(settings, x_mm, y_mm);
  };
}

/// After a calibration; a tilt that the engine fitted is commanded too.
inline DeltaAccuracy After(const DeltaOutcome& outcome,
                           const DeltaBuild<double>& build,
                           DeltaBed<double> bed = {}) {
  bed.slope_x -= outcome.tilt_x;
  bed.slope_y -= outcome.tilt_y;
  return DeltaAccuracyOf(build, bed, outcome.settings, 100);
}

/// The rms over the disc to which touches scattering by 10 um lead, to first order: the
/// root of the sum of squares of what each touch alone, 10 um off, leads to.
/// `calibrate` takes a probe and finds a machine without noise.
template <typename Calibrate>
double ForetoldRms_mm(const DeltaBuild<double>& build, const Calibrate& calibrate) {
  constexpr double kOff_mm = 0.01;
  double square = 0;
  int touches = 1;
  for (int off = 0; off < touches; ++off) {
    int count = 0;
    const DeltaOutcome outcome =
        calibrate([&](const DeltaModel<double>& settings, double x_mm, double y_mm) {
          auto motors_mm = DeltaTouchMotors(build, {}, settings, x_mm, y_mm);
          if (motors_mm && count++ == off) motors_mm->array() -= kOff_mm;
          return motors_mm;
        });
    touches = outcome.touches;
    square += std::pow(After(outcome, build).z_rms_mm, 2);
  }
  return std::sqrt(square);
}

}  // namespace caltwin::delta_rows
