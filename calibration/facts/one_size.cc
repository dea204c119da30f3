#include "calibration/facts/one_size.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include <fmt/format.h>

#include "calibration/facts/average.h"
#include "sim/base/units.h"
#include "sim/base/with_sd.h"
#include "sim/measure/row_flags.h"

namespace caltwin {
namespace {

bool IsTold(const Facts& facts, std::size_t axis) {
  return std::ranges::any_of(facts.all, [&](const Fact& fact) {
    return fact.axis == kAxisNames[axis] &&
           (fact.id == "scale" || fact.id == "offset" || fact.id == "known_ratio" ||
            fact.id == "settings");
  });
}

Fact OneSize(std::size_t axis, double size_mm, const std::vector<double>& errors_mm) {
  const Average average = AverageOf(errors_mm);
  const double error_mm = average.mean;
  const double sd_mm =
      errors_mm.size() < 2 ? kUnknown : average.sd / std::sqrt(average.num);
  const std::string off = Known(sd_mm) ? WithSd(std::abs(error_mm), sd_mm, "mm")
                                       : fmt::format("{:.3g} mm", std::abs(error_mm));
  const std::string size =
      fmt::format("The size of {:g} mm along {} is ", size_mm, "XYZ"[axis]);
  return {.id = "one_size",
          .axis = kAxisNames[axis],
          .figures = {{"change_um", UmFromMm(error_mm), UmFromMm(sd_mm)},
                      {"size_mm", size_mm}},
          .sentence =
              error_mm == 0
                  ? size + "right"
                  : size + fmt::format(
                               "too {} by {} ({:.2g} %). One size does not tell a "
                               "scale from a constant (walls, a first layer pressed "
                               "flat, how the calliper sits)",
                               error_mm > 0 ? "large" : "small",
                               off,
                               PercentFromFraction(std::abs(error_mm) / size_mm))};
}

}  // namespace

bool AreSizes(const Rows& rows) {
  return std::ranges::all_of(rows, [](const Row* row) {
    const int axis = AxisAlong(*row);
    return row->kind == RowKind::kPosition && axis >= 0 && row->flag != kMoveFlag &&
           row->home.empty() && row->setup.empty() &&
           row->cmd_mm[static_cast<std::size_t>(axis)] > 1 &&
           !Known(row->dir[static_cast<std::size_t>(axis)]);
  });
}

void FactsOfOneSize(const Rows& rows, Facts* facts) {
  constexpr double kSame_mm = 1e-3;
  if (!AreSizes(rows)) return;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double size_mm = kUnknown;
    bool is_one = true;
    std::vector<double> errors_mm;
    for (const Row* row : rows) {
      if (AxisAlong(*row) != static_cast<int>(axis)) continue;
      const double each_mm = row->cmd_mm[axis];
      is_one = is_one && (!Known(size_mm) || std::abs(each_mm - size_mm) < kSame_mm);
      size_mm = each_mm;
      errors_mm.push_back(row->value_mm);
    }
    if (errors_mm.empty() || !is_one || IsTold(*facts, axis)) continue;
    facts->all.push_back(OneSize(axis, size_mm, errors_mm));
  }
}

}  // namespace caltwin
