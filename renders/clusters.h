#pragma once

#include <string>
#include <vector>

#include "sim/measure/row.h"

namespace caltwin {

/// Touches that ought to read alike: one feature, one normal, one sense of approach,
/// one set of firmware settings, one placement and homing.
struct Cluster {
  std::string feature{};
  std::string approach{};  ///< The way the tip moved: "+x", "-z", "(0.71, 0.71, 0)".
  std::string settings{};  ///< Id of the firmware settings in force.
  std::vector<double> number{};    ///< Running number of each reading.
  std::vector<double> value_mm{};  ///< As the row has it: (reported - nominal) . n.

  double mean_mm() const;
  /// Standard deviation of a single reading; 0 for one reading.
  double sd_mm() const;
  double range_mm() const;
};

/// The touches of a table by cluster, in the order in which each was first met.
std::vector<Cluster> ClustersOf(const RowTable& table);

}  // namespace caltwin
