#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <fmt/format.h>

#include "calibration/facts/cells.h"
#include "calibration/facts/surface.h"
#include "sim/base/dense.h"
#include "sim/base/units.h"
#include "sim/base/with_sd.h"

namespace caltwin {
namespace {

constexpr Eigen::Index kTerms = 7;  // 1 x y x2 y2 xy and the sense.

// The sense in which an axis came to each row, by where the row before was touched; 0
// where it has not moved yet.
std::vector<double> SensesOf(const Rows& rows, std::size_t axis) {
  std::vector<double> senses = {0};
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const double moved_mm = rows[i]->cmd_mm[axis] - rows[i - 1]->cmd_mm[axis];
    senses.push_back(moved_mm > 0 ? 1 : moved_mm < 0 ? -1 : senses.back());
  }
  return senses;
}

double HalfRange(const Rows& rows, std::size_t axis) {
  const auto [low, high] = std::ranges::minmax(
      rows, {}, [axis](const Row* row) { return row->cmd_mm[axis]; });
  return (high->cmd_mm[axis] - low->cmd_mm[axis]) / 2;
}

double MeanOf(const Rows& rows, std::size_t axis) {
  double sum_mm = 0;
  for (const Row* row : rows) sum_mm += row->cmd_mm[axis];
  return sum_mm / static_cast<double>(rows.size());
}

/// What the sense of an axis changes beside a smooth shape.
struct Gap {
  double size_mm = 0, sd_mm = kUnknown;
};

Gap GapOf(const Rows& all, std::size_t axis) {
  constexpr double kFewestOfSense = 4, kFewestDof = 5, kDetermined = 1e-6;
  const std::vector<double> all_senses = SensesOf(all, axis);
  Rows rows;
  std::vector<double> senses;
  double plus = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all_senses[i] == 0) continue;
    rows.push_back(all[i]);
    senses.push_back(all_senses[i]);
    plus += all_senses[i] > 0 ? 1 : 0;
  }
  const auto num = static_cast<Eigen::Index>(rows.size());
  const bool is_enough = static_cast<double>(num - kTerms) >= kFewestDof &&
                         plus >= kFewestOfSense &&
                         static_cast<double>(num) - plus >= kFewestOfSense;
  const double half_x_mm = rows.empty() ? 0 : HalfRange(rows, 0);
  const double half_y_mm = rows.empty() ? 0 : HalfRange(rows, 1);
  if (!is_enough || half_x_mm <= 0 || half_y_mm <= 0) return {};
  Eigen::MatrixXd columns(num, kTerms);
  Eigen::VectorXd heights_mm(num);
  for (Eigen::Index i = 0; i < num; ++i) {
    const Row& row = *rows[static_cast<std::size_t>(i)];
    const double x = (row.cmd_mm[0] - MeanOf(rows, 0)) / half_x_mm;
    const double y = (row.cmd_mm[1] - MeanOf(rows, 1)) / half_y_mm;
    columns.row(i) << 1, x, y, x * x, y * y, x * y,
        senses[static_cast<std::size_t>(i)] / 2;
    heights_mm[i] = row.value_mm;
  }
  const Eigen::MatrixXd normal = columns.transpose() * columns;
  if (EigenvaluesOf(normal)[0] < kDetermined * normal.trace()) return {};
  const Cholesky solver(normal);
  const Eigen::VectorXd sizes = solver.Solve(columns.transpose() * heights_mm);
  const Eigen::MatrixXd inverse =
      solver.SolveEach(Eigen::MatrixXd::Identity(kTerms, kTerms));
  const double left_mm2 = (heights_mm - columns * sizes).squaredNorm();
  const double noise_mm2 = left_mm2 / static_cast<double>(num - kTerms);
  return {sizes[kTerms - 1], std::sqrt(noise_mm2 * inverse(kTerms - 1, kTerms - 1))};
}

std::map<std::string, Rows> MapsOf(const Rows& rows) {
  constexpr double kUp = 0.999;
  std::map<std::string, Rows> maps;
  for (const Row* row : rows) {
    const bool is_height = row->kind == RowKind::kTouch && row->n[2] > kUp &&
                           Known(row->cmd_mm[0]) && Known(row->cmd_mm[1]) &&
                           !Known(row->dir[0]) && !Known(row->dir[1]);
    if (is_height)
      maps[row->campaign + "|" + row->home + "|" + row->feature].push_back(row);
  }
  return maps;
}

}  // namespace

void FactsOfArrival(const std::vector<const Row*>& rows, Facts* facts) {
  constexpr double kSure = 6, kLeast_mm = 0.003;
  for (const auto& [key, map] : MapsOf(rows)) {
    for (const std::size_t axis : {0U, 1U}) {
      const Gap gap = GapOf(map, axis);
      const bool is_sure = Known(gap.sd_mm) && std::abs(gap.size_mm) > kLeast_mm &&
                           std::abs(gap.size_mm) > kSure * gap.sd_mm;
      if (!is_sure) continue;
      const char letter = "XY"[axis];
      std::erase_if(facts->all, [](const Fact& fact) {
        return fact.id == "form" || fact.id == "twist";
      });
      facts->all.push_back(
          {.id = "cross_reversal",
           .axis = axis == 0 ? "x" : "y",
           .word = "z",
           .figures = {{"gap_um", UmFromMm(gap.size_mm), UmFromMm(gap.sd_mm)}},
           .sigmas = std::abs(gap.size_mm) / gap.sd_mm,
           .sentence = fmt::format(
               "The height reads {} more where {} arrived in its + sense than where it "
               "arrived in its - sense (by the order of the touches): stripes in the "
               "map. "
               "The {} carriage tilts or shifts with the sense in which it is pulled "
               "(play of its bearings, wheels or spindle mount). The bed is not to "
               "blame; "
               "probe all points arriving in one sense, and take out that play",
               WithSd(UmFromMm(gap.size_mm), UmFromMm(gap.sd_mm), "um"),
               letter,
               letter),
           .is_answer = true});
    }
  }
}

}  // namespace caltwin
