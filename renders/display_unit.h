#pragma once

#include <string>
#include <string_view>

namespace caltwin {

/// How a quantity's errors and uncertainties are shown: millimetres in micrometres,
/// since that is how large they are; everything else in its own unit.
struct ErrorUnit {
  std::string name{};
  double per_unit = 1;  ///< Shown number per number in the quantity's unit.
};
ErrorUnit ErrorUnitOf(std::string_view unit);

/// A unit as people write it: "1/mm" is "steps/mm", "um" is "µm".
std::string UnitText(std::string_view unit);

/// The unit of a parameter, told from its name where the result says none: the suffix
/// of its last part ("bed_tilt.slope_x_mrad"), else that of its cause.
std::string UnitOfName(std::string_view name);

}  // namespace caltwin
