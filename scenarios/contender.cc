#include "scenarios/contender.h"

#include <cmath>
#include <cstddef>
#include <limits>

namespace caltwin {

Spread SpreadOf(std::vector<double> values) {
  if (values.empty()) return {};
  constexpr double k95 = 1.959964;
  std::ranges::sort(values);
  const auto num = static_cast<double>(values.size());
  // The value at a rank that counts from 1, held within what there is.
  const auto at = [&](double rank) {
    return values[static_cast<std::size_t>(std::clamp(rank, 1.0, num)) - 1];
  };
  const double half = k95 * std::sqrt(num) / 2;
  // Of fewer values not even their range holds the median with 95 %.
  constexpr double kFewest = 6;
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  const bool has_interval = num >= kFewest;
  return {.median = (at(std::floor((num + 1) / 2)) + at(std::ceil((num + 1) / 2))) / 2,
          .p95 = at(std::ceil(0.95 * num)),
          .low = has_interval ? at(std::floor(num / 2 - half)) : unknown,
          .high = has_interval ? at(std::ceil(1 + num / 2 + half)) : unknown};
}

}  // namespace caltwin
