#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/measure/import/growth_fit.h"
#include "sim/measure/import/klipper_thermal.h"

namespace caltwin {
namespace {

constexpr double kLeastRange_k = 3;
constexpr double kMostFrames = 5;
constexpr double kLeastExplained = 0.5;  // Of the variance, or temperature is not it.

}  // namespace

GrowthPerKelvin GrowthOf(const RowTable& table, const FrameLogHeader& header) {
  double least_c = INFINITY, most_c = -INFINITY;
  for (const Row& row : table.rows) {
    if (!Known(row.temp_frame_c)) continue;
    least_c = std::min(least_c, row.temp_frame_c);
    most_c = std::max(most_c, row.temp_frame_c);
  }
  if (!(most_c - least_c >= kLeastRange_k)) return {};
  const GrowthFit fit = PlainGrowth(table);
  GrowthPerKelvin growth{.growth_mm_per_k = fit.frame_mm_per_k,
                         .range_k = most_c - least_c};
  if (!(fit.explained >= kLeastExplained)) return growth;
  const double needed_mm = std::abs(fit.frame_mm_per_k) / header.expansion_per_k;
  growth.metres_needed = needed_mm / MmFromM(1.0);
  if (Known(header.frame_length_mm)) growth.ratio = needed_mm / header.frame_length_mm;
  return growth;
}

std::string StepFault(const GrowthPerKelvin& growth, const FrameLogHeader& header) {
  if (!(growth.ratio > kMostFrames)) return "";
  return fmt::format(
      "a step of {} mm makes the trigger height move by {:.0f} um per kelvin of the "
      "frame: {:.1f} m of it would have to grow, {:.0f} times its {:.0f} mm",
      header.step_mm,
      UmFromMm(std::abs(growth.growth_mm_per_k)),
      growth.metres_needed,
      growth.ratio,
      header.frame_length_mm);
}

}  // namespace caltwin
