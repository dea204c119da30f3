#include <algorithm>
#include <cmath>

#include <Eigen/Dense>
#include <fmt/format.h>

#include "sim/base/median.h"
#include "sim/base/units.h"
#include "sim/measure/import/klipper_thermal.h"

namespace caltwin {
namespace {

constexpr double kLeastRange_k = 3;
constexpr double kMostFrames = 5;
constexpr double kGrossly = 20;          // Median residuals.
constexpr double kLeastExplained = 0.5;  // Of the variance, or temperature is not it.

}  // namespace

// Least squares of the height over frame and bed temperature and an offset, once more
// without readings so far off that homing must have gone wrong.
GrowthPerKelvin GrowthOf(const RowTable& table, const FrameLogHeader& header) {
  std::vector<Eigen::Vector3d> terms;
  std::vector<double> values_mm;
  double least_c = INFINITY, most_c = -INFINITY;
  for (const Row& row : table.rows) {
    if (!Known(row.temp_frame_c)) continue;
    const double bed_c = Known(row.temp_bed_c) ? row.temp_bed_c : 0;
    terms.emplace_back(row.temp_frame_c, bed_c, 1);
    values_mm.push_back(row.value_mm);
    least_c = std::min(least_c, row.temp_frame_c);
    most_c = std::max(most_c, row.temp_frame_c);
  }
  if (terms.size() < 10 || most_c - least_c < kLeastRange_k) return {};
  std::vector<bool> is_used(terms.size(), true);
  Eigen::Vector3d fit = Eigen::Vector3d::Zero();
  double explained = 0;
  for (int pass = 0; pass < 2; ++pass) {
    Eigen::Matrix3d normal = 1e-9 * Eigen::Matrix3d::Identity();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    double sum = 0, square = 0, residual_square = 0, count = 0;
    for (std::size_t i = 0; i < terms.size(); ++i) {
      if (!is_used[i]) continue;
      normal += terms[i] * terms[i].transpose();
      right += terms[i] * values_mm[i];
      sum += values_mm[i];
      square += values_mm[i] * values_mm[i];
      count += 1;
    }
    fit = normal.ldlt().solve(right);
    std::vector<double> sizes_mm;
    for (std::size_t i = 0; i < terms.size(); ++i) {
      const double residual_mm = values_mm[i] - fit.dot(terms[i]);
      sizes_mm.push_back(std::abs(residual_mm));
      if (is_used[i]) residual_square += residual_mm * residual_mm;
    }
    explained = 1 - residual_square / std::max(square - sum * sum / count, 1e-300);
    const double usual_mm = Median(sizes_mm);
    for (std::size_t i = 0; i < terms.size(); ++i) {
      is_used[i] = sizes_mm[i] <= kGrossly * usual_mm;
    }
  }
  GrowthPerKelvin growth{.growth_mm_per_k = fit[0], .range_k = most_c - least_c};
  if (explained < kLeastExplained || !std::isfinite(fit[0])) return growth;
  const double needed_mm = std::abs(fit[0]) / header.expansion_per_k;
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
