#include "sim/measure/import/bare_grid.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

#include "sim/measure/import/fields.h"

namespace caltwin {
namespace {

// The numbers of a line that holds nothing else; empty of any other line. The first may
// be a count: of the grid's lines.
std::vector<double> NumbersOf(std::string_view line) {
  std::vector<double> numbers;
  // How consoles mark what came and what was sent.
  for (const std::string_view mark : {"<-", "->", ">", "<"}) {
    if (line.starts_with(mark)) line.remove_prefix(mark.size());
  }
  constexpr std::string_view kBetween = " \t,;";
  std::size_t at = 0;
  while ((at = line.find_first_not_of(kBetween, at)) != std::string_view::npos) {
    const std::size_t end = std::min(line.size(), line.find_first_of(kBetween, at));
    std::string_view word = line.substr(at, end - at);
    if (word.starts_with('+')) word.remove_prefix(1);
    const auto number = NumberOf(word);
    const bool is_height = number && (*number == 0 || word.find('.') != word.npos);
    const bool is_count = number && numbers.empty() && *number == std::round(*number);
    if (!is_height && !is_count) return {};
    numbers.push_back(*number);
    at = end;
  }
  return numbers;
}

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
  for (const auto& row : rows) {
    const auto [low, high] = std::ranges::minmax(row);
    least_mm = std::min(least_mm, low);
    most_mm = std::max(most_mm, high);
  }
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
    std::vector<double> numbers = NumbersOf(line.text);
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
