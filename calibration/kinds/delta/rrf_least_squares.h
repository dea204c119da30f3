#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "calibration/kinds/delta/bench.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {

/// The points of which 6 factors on 16 points speaks in docs/delta-engines.md: eight at
/// the radius, six at half of it, the centre and one more.
std::vector<Eigen::Vector2d> RrfProbePoints(double radius_mm);

/// How RepRapFirmware's `M558`/`G32` calibration of a delta is asked for.
struct RrfOptions {
  /// 3 endstops; 4 + radius; 6 + angles of towers a and b; 7 + rods (all three alike);
  /// 8 = 6 + bed tilt in x and y; 9 = 8 + rods.
  int factors = 6;
  std::vector<Eigen::Vector2d> points = RrfProbePoints(100);
};

/// Least squares in the manner of RepRapFirmware: two Gauss-Newton rounds on the normal
/// equations, derivatives of the height by central differences of 0.2 mm or deg.
///
/// The model is three rods of one length on one radius; every height weighs alike.
/// What it says, `said_mm`, is the rms of the heights as its last model predicts them
/// at the fitted points: in sample, not divided by the degrees of freedom. Not done
/// where the points do not tell the factors apart (`messages` says so).
/// @param touches that many at least as there are factors.
/// @param factors as in RrfOptions; an InputError for any other.
DeltaOutcome FitRrf(std::span<const DeltaTouch> touches,
                    const DeltaModel<double>& start,
                    int factors);

/// Touches every point once with the settings it starts from, then FitRrf.
DeltaOutcome CalibrateRrf(const DeltaProbe& probe,
                          const DeltaModel<double>& start,
                          const RrfOptions& options = {});

}  // namespace caltwin
