#include "sim/measure/import/bare_grid.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "sim/measure/import/console_grid.h"
#include "sim/measure/import/fields.h"

namespace caltwin {
namespace {

using Grid = std::vector<std::vector<double>>;

// Whether the first column counts the lines; of one that is a count and counts none no
// grid is made.
bool CountsLines(const Grid& rows) {
  for (std::size_t i = 1; i < rows.size(); ++i) {
    if (std::abs(std::abs(rows[i][0] - rows[i - 1][0]) - 1) > 1e-9) return false;
  }
  return rows.size() > 1;
}

bool IsGrid(Grid rows) {
  constexpr std::size_t kFewest = 3, kMostTimes = 3;
  constexpr double kMost_mm = 20;
  if (CountsLines(rows)) {
    for (auto& row : rows) row.erase(row.begin());
  }
  if (rows.size() < kFewest || rows.front().size() < kFewest) return false;
  const std::size_t num = rows.front().size();
  if (rows.size() > kMostTimes * num || num > kMostTimes * rows.size()) return false;
  double least_mm = HUGE_VAL, most_mm = -HUGE_VAL;
  std::size_t whole = 0;
  for (const auto& row : rows) {
    for (const double height_mm : row) {
      if (!Known(height_mm)) return false;
      least_mm = std::min(least_mm, height_mm);
      most_mm = std::max(most_mm, height_mm);
      whole += height_mm != 0 && height_mm == std::round(height_mm) ? 1 : 0;
    }
  }
  // Counts, and no heights.
  if (2 * whole > rows.size() * num) return false;
  // A column of places goes on from line to line, by far more than heights do.
  for (std::size_t k = 0; k < num; ++k) {
    constexpr double kFar_mm = 2;
    bool rises = true;
    for (std::size_t i = 1; i < rows.size(); ++i) rises &= rows[i][k] > rows[i - 1][k];
    if (rises && rows.back()[k] - rows.front()[k] > kFar_mm) return false;
  }
  return most_mm > least_mm && most_mm - least_mm < kMost_mm;
}

}  // namespace

std::set<int> BareGrids(const std::string& text) {
  std::set<int> begins;
  Grid rows;
  int first = 0;
  const auto end = [&] {
    if (IsGrid(rows)) begins.insert(first);
    rows.clear();
  };
  for (const TextLine& line : LinesOf(text)) {
    std::vector<double> numbers = GridHeightsIn(line.text);
    const bool is_on = !rows.empty() && numbers.size() == rows.front().size();
    if (!is_on) end();
    if (numbers.empty()) continue;
    if (rows.empty()) first = line.line;
    rows.push_back(std::move(numbers));
  }
  end();
  return begins;
}

}  // namespace caltwin
