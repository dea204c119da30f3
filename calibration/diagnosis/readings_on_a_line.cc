#include "calibration/diagnosis/readings_on_a_line.h"

#include <algorithm>
#include <iterator>

namespace caltwin {

std::optional<double> Between(const std::vector<Reading>& readings, double at_mm) {
  const auto above = std::ranges::lower_bound(readings, at_mm, {}, &Reading::at_mm);
  if (above == readings.end()) return std::nullopt;
  if (above->at_mm == at_mm) return above->value_mm;
  if (above == readings.begin()) return std::nullopt;
  const Reading& below = *std::prev(above);
  const double part = (at_mm - below.at_mm) / (above->at_mm - below.at_mm);
  return below.value_mm + part * (above->value_mm - below.value_mm);
}

double Nearest(const std::vector<Reading>& readings, double at_mm) {
  const Reading& end =
      at_mm < readings.front().at_mm ? readings.front() : readings.back();
  return Between(readings, at_mm).value_or(end.value_mm);
}

}  // namespace caltwin
