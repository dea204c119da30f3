#pragma once

#include <optional>
#include <vector>

namespace caltwin {

struct PlacedReading {
  double at_mm = 0;
  double value_mm = 0;
};

/// On the line through the two neighbours; none beyond the ends. `readings` in the
/// order of their places.
std::optional<double> ReadingBetween(const std::vector<PlacedReading>& readings,
                                     double at_mm);

/// The same, beyond the ends the reading there. At least one reading.
double ReadingNearest(const std::vector<PlacedReading>& readings, double at_mm);

}  // namespace caltwin
