#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "calibration/diagnosis/observed.h"

namespace caltwin {

/// One covariate over all rows. Words are CONTRACT's: x y z t temp dir_x dir_y dir_z
/// since_rev feed load theta, and of a delta motor_a.. dir_a... `temp` takes the sensor
/// that moves most.
struct Covariate {
  std::string word{};
  Eigen::VectorXd values{};
  double min = 0, max = 0;
  int num_distinct = 0;  ///< Counted up to 64.
  bool is_periodic = false;

  /// Scaled to -1 .. 1 over the rows.
  double Scaled(double value) const;
};

/// None where some row does not know it, or where it is the same everywhere.
std::optional<Covariate> CovariateOf(const Observed& observed, std::string_view word);

/// How a motion in a channel shows in each row: x y z (motion of the tool), a b c (of a
/// delta's carriage, + down), probe
/// (pre-travel grows), bed (the surface rises); at a printer's station nozzle (longer)
/// and gap (under it).
Eigen::VectorXd ChannelOf(const Observed& observed, std::string_view channel);

}  // namespace caltwin
