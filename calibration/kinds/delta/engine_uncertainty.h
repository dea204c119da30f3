#pragma once

#include <span>
#include <string>
#include <vector>

#include "calibration/kinds/delta/bench.h"
#include "calibration/kinds/delta/joint.h"
#include "calibration/loop/outcome.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {

/// A firmware's calibration that minimises the sum of squares of the touched heights
/// over some of the machine's numbers, every height weighing alike, without beliefs.
struct HeightSquares {
  std::string procedure{};
  std::vector<int> knobs{};  ///< What it moves; all else it takes for as drawn.
  std::vector<DeltaTouch> touches{};
  /// As far as the machine's drawing goes: what twists where a tower stands round.
  DeltaBuild<double> drawn{};
};

/// How sure settings so found are, and how their errors go together.
struct EngineUncertainty {
  std::vector<Estimate> estimates{};  ///< Of the knobs, values left for the caller.
  std::vector<Correlations> correlations{};
};

/// The uncertainty that the engine itself does not state, of settings as the machine is
/// built. With A the slopes of the heights by what it moves, B by what its model has
/// not (rods apart, leaning towers, belts, the bed's tilt and shape) and G = (A^T A)^-1
/// A^T,
///
///   settings - built = G noise + G B lacking,   C = G (V + B P B^T) G^T
///
/// V the touches' variances, P those of kDeltaKnobs, straight about `found`; a twist
/// strays by that of its tower's angle too, where the engine moves the angle and the
/// drawing says that a carriage is twisted with it. Empty where the touches do not tell
/// the knobs apart. Tower angles count against tower c.
EngineUncertainty UncertaintyOfHeightSquares(const DeltaModel<double>& found,
                                             const HeightSquares& engine);

/// How the errors of everything that the readings of a joint fit told go together;
/// fewer than two: none.
std::vector<Correlations> CorrelationsOfDelta(const DeltaJointFit& fit);

/// A knob whose sd is still more than this of its prior's was not told.
inline constexpr double kDeltaNotTold = 0.9;

}  // namespace caltwin
