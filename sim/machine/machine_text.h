#pragma once

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "sim/machine/machine.h"

namespace caltwin {

/// What a firmware's settings say of one axis; not a number, or none: nothing.
struct AxisSettingsText {
  static constexpr double kUnstated = std::numeric_limits<double>::quiet_NaN();

  double min_mm = 0;
  double max_mm = kUnstated;
  double steps_per_mm = kUnstated;
  double full_steps_per_rev = kUnstated;
  double microsteps = kUnstated;
  double backlash_mm = kUnstated;
  double max_feed_mm_s = kUnstated;
  double acceleration_mm_s2 = kUnstated;
  std::optional<HomeEnd> home{};
};

/// A machine of three straight axes as a firmware's settings have it.
struct CartesianMachineText {
  std::string source{};  ///< The settings' file.
  std::string name{};
  bool is_corexy = false;
  bool has_belts = true;                   ///< Along x and y; else screws.
  std::array<AxisSettingsText, 3> axes{};  ///< x y z; their steps/mm are known.
  /// Where three screws carry the bed; empty: one Z.
  std::vector<std::array<double, 2>> screws_mm{};
  /// Low and high corner of a gantry that hangs on four motors of Z; empty: it does
  /// not.
  std::vector<std::array<double, 2>> corners_mm{};
  /// Where along x the two motors of Y are.
  std::optional<std::array<double, 2>> beam_mm{};
};

/// The text of a machine file: travels as stated, else 200 mm; drives of 200 full steps
/// and, where nobody states them, sixteenths.
std::string CartesianMachineYaml(const CartesianMachineText& machine);

}  // namespace caltwin
