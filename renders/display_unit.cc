#include "renders/display_unit.h"

#include "sim/base/units.h"

namespace caltwin {

ErrorUnit ErrorUnitOf(std::string_view unit) {
  if (unit == "mm") return {.name = "µm", .per_unit = UmFromMm(1.0)};
  return {.name = UnitText(unit), .per_unit = 1};
}

std::string UnitText(std::string_view unit) {
  if (unit == "1/mm") return "steps/mm";
  if (unit == "um") return "µm";
  if (unit == "deg") return "°";
  return std::string(unit);
}

std::string UnitOfName(std::string_view name) {
  if (name.starts_with("steps_per_mm")) return "1/mm";
  const std::size_t underscore = name.rfind('_');
  const std::size_t dot = name.rfind('.');
  const bool has_suffix = underscore != std::string_view::npos &&
                          dot != std::string_view::npos && underscore > dot;
  if (has_suffix) return std::string(name.substr(underscore + 1));
  return "mm";
}

}  // namespace caltwin
