#include "calibration/diagnosis/readings_on_a_line.h"

#include <algorithm>
#include <iterator>

namespace caltwin {

std::optional<double> ReadingBetween(const std::vector<PlacedReading>& readings,
                                     double at_mm) {
  const auto above =
      std::ranges::lower_bound(readings, at_mm, {}, &PlacedReading::at_mm);
  if (above == readings.end()) return std::nullopt;
  if (above->at_mm == at_mm) return above->value_mm;
  if (above == readings.begin()) return std::nullopt;
  const PlacedReading& below = *std::prev(above);
  const double part = (at_mm - below.at_mm) / (above->at_mm - below.at_mm);
  return below.value_mm + part * (above->value_mm - below.value_mm);
}

double ReadingNearest(const std::vector<PlacedReading>& readings, double at_mm) {
  const PlacedReading& end =
      at_mm < readings.front().at_mm ? readings.front() : readings.back();
  return ReadingBetween(readings, at_mm).value_or(end.value_mm);
}

}  // namespace caltwin
