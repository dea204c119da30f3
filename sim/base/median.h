#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace caltwin {

/// Standard deviation of normal noise over the median of its magnitude.
inline constexpr double kSigmaOfMedian = 1.4826;

/// The upper of the two middle values where their number is even; 0 of none.
inline double Median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

}  // namespace caltwin
