#include "sim/measure/import/climb.h"

#include <cmath>
#include <cstddef>

#include <fmt/format.h>

namespace caltwin {
namespace {

constexpr std::size_t kLeastTouches = 5;
constexpr double kLeastClimb_mm = 0.1;

}  // namespace

std::string ClimbText(const std::vector<double>& heights_mm) {
  if (heights_mm.size() < kLeastTouches) return "";
  const double climb_mm = heights_mm.back() - heights_mm.front();
  if (std::abs(climb_mm) < kLeastClimb_mm) return "";
  for (std::size_t i = 1; i < heights_mm.size(); ++i) {
    if ((heights_mm[i] - heights_mm[i - 1]) * climb_mm <= 0) return "";
  }
  return fmt::format(
      "the reported height {} with every touch, by {:.3f} mm in {} touches of one "
      "place",
      climb_mm > 0 ? "climbs" : "sinks",
      std::abs(climb_mm),
      heights_mm.size());
}

}  // namespace caltwin
