#pragma once

#include "sim/kinds/triple_z/plant.h"
#include "sim/machine/kinds/triple_z/drawing.h"

namespace caltwin {

/// 95 % quantile of the nozzle's position error over the bed [mm] at 1000 seeded poses
/// of the travel, each come to from below and from above, the mean error taken off: by
/// the closed forms, the screws raised so.
double TripleZPositionP95_mm(const BuiltTripleZ& built, const Vec3<double>& raised_mm);

/// How a bed truly stands, on a lattice of 11 by 11 within 20 mm of the edges.
struct TrueLevel {
  double mean_mm = 0;  ///< Of the magnitudes, against the reference.
  double max_mm = 0;
  double flat_rms_mm = 0;  ///< Its mean left out.
};
TrueLevel TrueLevelOf(const BuiltTripleZ& built,
                      const Vec3<double>& raised_mm,
                      double reference_mm);

}  // namespace caltwin
