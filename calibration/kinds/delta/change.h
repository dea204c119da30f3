#pragma once

#include "calibration/kinds/delta/joint.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {

/// A figure, and what a fit leaves open of it.
struct DeltaMoved {
  double by = 0;
  double sd = 0;

  /// More than chance would move it: two standard deviations.
  bool IsTold() const;
};

/// What other settings change on the machine that a fit found, over a disc on its bed.
struct DeltaChange {
  DeltaMoved height_mm{};  ///< Of the nozzle over the bed, rms.
  DeltaMoved place_mm{};   ///< In x and y together, rms.
  DeltaMoved scale{};      ///< Moved over commanded, in the plane.

  /// Whether one of them is told. Else the settings in force are as good as any, and
  /// others would only make them wander from one calibration to the next.
  bool IsTold() const;
};

/// Neglects what the fit's model lacks; its uncertainty is that of its readings and
/// priors alone.
DeltaChange ChangeOf(const DeltaJointFit& fit,
                     const DeltaModel<double>& from,
                     const DeltaModel<double>& to,
                     double radius_mm);

}  // namespace caltwin
