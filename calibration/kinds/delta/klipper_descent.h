#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "calibration/kinds/delta/bench.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {

/// The seven points of Klipper's DELTA_CALIBRATE: the centre, then 95, 90, 85, 70, 75
/// and 80 % of the radius at 90, 150, 210, 270, 330 and 30 deg.
std::vector<Eigen::Vector2d> KlipperProbePoints(double radius_mm);

/// Both ends of the twelve distances of Klipper's calibration print (pillars 65 mm from
/// the centre, edges of a ridge 4.5 mm from a pillar's middle): six along the spokes,
/// six from pillar to pillar.
struct KlipperRidge {
  Eigen::Vector2d first_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d second_mm = Eigen::Vector2d::Zero();
};
std::vector<KlipperRidge> KlipperPrint();

struct KlipperOptions {
  std::vector<Eigen::Vector2d> points = KlipperProbePoints(100);
  /// With any, the three arms are fitted too (nine parameters in place of six).
  std::vector<DeltaDistance> distances{};
};

/// Coordinate descent in the manner of Klipper: each parameter in turn takes a step up
/// or, failing that, down; a step that helps grows by 10 %, one that helps neither way
/// shrinks by 10 %, from 1 mm or 1 deg until all of them together fall below 1e-5 or
/// 10 000 rounds are over.
///
/// Parameters: the radius (of all towers), the angles of a and b, three endstops and,
/// with distances, three arms. The sum of squares of the heights weighs
/// num_distances / (0.5 num_heights) times that of the distances.
///
/// Klipper reports no deviation: `said_mm` is the rms of the heights that its log
/// lists, in sample. It is always done. `messages`: the lines of its `printer.cfg`.
DeltaOutcome FitKlipper(std::span<const DeltaTouch> touches,
                        std::span<const DeltaDistance> distances,
                        const DeltaModel<double>& start);

/// Touches every point once with the settings it starts from, then FitKlipper.
DeltaOutcome CalibrateKlipper(const DeltaProbe& probe,
                              const DeltaModel<double>& start,
                              const KlipperOptions& options = {});

}  // namespace caltwin
