#pragma once

#include <optional>

#include <Eigen/Core>

namespace caltwin {

/// A wave whose period and size drift along the way:
///
///   value(q) = smooth(q) + a(q) cos(phi(q)),   phi'(q) = 2 pi / period(q)
///
/// found piece by piece, each piece some five periods long with a period, a size and a
/// phase of its own.
struct DriftingWave {
  double period = 0;  ///< The middle of those of all pieces, in the unit of q.
  double least_period = 0, most_period = 0;
  double size = 0;  ///< Amplitude: the middle, in the unit of the values.
  double least_size = 0, most_size = 0;
  /// Of the variance about a line a piece that the waves explain, degrees of freedom
  /// counted.
  double share = 0;
  /// The same of a wave with one period throughout, whose size may change.
  double share_of_fixed = 0;
};

/// `at` ascending, `values` beside it. None where no wave explains three fifths of what
/// a cubic leaves, where a wave of one period, or two of them that beat, leave
/// less than twice as much, or where
/// there are fewer than 40 places or three pieces.
std::optional<DriftingWave> DriftingWaveOf(const Eigen::VectorXd& at,
                                           const Eigen::VectorXd& values);

}  // namespace caltwin
