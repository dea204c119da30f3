// Whether a part of a campaign was written in micrometres.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "calibration/diagnosis/plausible_parts.h"
#include "sim/base/median.h"
#include "sim/base/units.h"

namespace caltwin {
namespace {

constexpr std::size_t kFewest = 3;

struct Spread {
  double middle_mm = 0;
  double size_mm = 0;  ///< 1.48 median deviations.
};

Spread SpreadOf(const std::vector<double>& values_mm) {
  Spread spread{.middle_mm = Median(values_mm)};
  std::vector<double> far_mm;
  for (const double value_mm : values_mm) {
    far_mm.push_back(std::abs(value_mm - spread.middle_mm));
  }
  spread.size_mm = kSigmaOfMedian * Median(far_mm);
  return spread;
}

// A thousandth of what lies far off is where the others lie, and scatters as they do,
// within a factor of five: homings that differ by twenty times are no unit.
bool AreMicrometres(const std::vector<double>& far_mm, const Spread& others) {
  constexpr double kNear = 10, kSame = 200;
  const auto fitting = std::ranges::count_if(far_mm, [&](double value_mm) {
    return std::abs(MmFromUm(value_mm) - others.middle_mm) < kNear * others.size_mm;
  });
  return far_mm.size() >= kFewest &&
         static_cast<double>(fitting) >= 0.9 * static_cast<double>(far_mm.size()) &&
         SpreadOf(far_mm).size_mm > kSame * others.size_mm;
}

}  // namespace

void DoubtBlocks(const std::vector<const Row*>& rows, std::vector<Doubt>* doubts) {
  constexpr double kFar_mm = 1, kSmall_mm = 0.2;
  std::map<std::string, std::vector<const Row*>> campaigns;
  for (const Row* row : rows) campaigns[row->campaign].push_back(row);
  for (const auto& [name, own] : campaigns) {
    std::vector<double> values_mm, far_mm;
    std::vector<std::int64_t> numbers;
    for (const Row* row : own) values_mm.push_back(row->value_mm);
    const Spread all = SpreadOf(values_mm);
    for (const Row* row : own) {
      if (std::abs(row->value_mm - all.middle_mm) < kFar_mm) continue;
      far_mm.push_back(row->value_mm);
      numbers.push_back(row->row);
    }
    if (all.size_mm > kSmall_mm || !AreMicrometres(far_mm, all)) continue;
    doubts->push_back(
        {.kind = "units_differ",
         .message = fmt::format("campaign {}: {} of its {} rows ({} to {}) read "
                                "thousands of times as much "
                                "as the others, the first {:.4g} mm",
                                name,
                                far_mm.size(),
                                own.size(),
                                numbers.front(),
                                numbers.back(),
                                far_mm.front()),
         .hint = "a thousandth of them is what the others read: those rows are in "
                 "micrometres",
         .rows = numbers,
         .refuse = true});
  }
}

}  // namespace caltwin
