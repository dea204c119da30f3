#pragma once

#include <array>
#include <string>
#include <vector>

#include "sim/measure/row.h"

namespace caltwin {

/// What a firmware's settings say of one axis; kUnknown: nothing.
struct AxisText {
  double min_mm = 0;
  double max_mm = kUnknown;
  double steps_per_mm = kUnknown;
  double microsteps = kUnknown;
  double backlash_mm = kUnknown;
};

/// A machine of three straight axes as a firmware's settings have it.
struct CartesianMachineText {
  std::string source{};  ///< The settings' file.
  std::string name{};
  bool is_corexy = false;
  std::array<AxisText, 3> axes{};  ///< x y z; their steps/mm are known.
  /// Where three screws carry the bed; empty: one Z.
  std::vector<std::array<double, 2>> screws_mm{};
};

/// The text of a machine file: travels as stated, else 200 mm; drives of 200 full steps
/// and, where nobody states them, sixteenths.
std::string CartesianMachineYaml(const CartesianMachineText& machine);

}  // namespace caltwin
