#include "scenarios/position_error.h"

#include <algorithm>

#include "sim/base/require.h"

namespace caltwin {

double P95AboutMean_mm(const std::vector<Vec3<double>>& errors_mm) {
  Require(errors_mm.size() >= 2, "a quantile is of several errors");
  Vec3<double> sum_mm = Vec3<double>::Zero();
  for (const Vec3<double>& error_mm : errors_mm) sum_mm += error_mm;
  const Vec3<double> mean_mm = sum_mm / static_cast<double>(errors_mm.size());
  std::vector<double> sizes_mm;
  for (const Vec3<double>& error_mm : errors_mm) {
    sizes_mm.push_back((error_mm - mean_mm).norm());
  }
  const auto rank = static_cast<std::ptrdiff_t>(sizes_mm.size() * 95 / 100);
  const auto p95 = sizes_mm.begin() + rank - 1;
  std::ranges::nth_element(sizes_mm, p95);
  return *p95;
}

}  // namespace caltwin
