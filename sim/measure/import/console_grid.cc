#include "sim/measure/import/console_grid.h"

#include <algorithm>
#include <string>

#include "sim/measure/import/fields.h"

namespace caltwin {
namespace {

// "( 10,294)" from `at` on: both numbers, and where it ends.
std::optional<std::pair<double, double>> CornerAt(std::string_view text,
                                                  std::size_t* at) {
  const std::size_t open = text.find('(', *at);
  const std::size_t close = text.find(')', open);
  if (open == std::string_view::npos || close == std::string_view::npos) {
    return std::nullopt;
  }
  const std::string_view inside = text.substr(open + 1, close - open - 1);
  const std::size_t comma = inside.find(',');
  if (comma == std::string_view::npos) return std::nullopt;
  const auto trimmed = [](std::string_view part) {
    const std::size_t first = part.find_first_not_of(' ');
    if (first == std::string_view::npos) return std::string_view();
    return part.substr(first, part.find_last_not_of(' ') + 1 - first);
  };
  const auto x = NumberOf(trimmed(inside.substr(0, comma)));
  const auto y = NumberOf(trimmed(inside.substr(comma + 1)));
  *at = close + 1;
  if (!x || !y) return std::nullopt;
  return std::pair{*x, *y};
}

bool LooksLikeRow(std::string_view text) {
  return text.find('|') != std::string_view::npos ||
         text.find('.') != std::string_view::npos;
}

// The words of a line, where all of them count up from 0 or 1.
std::size_t NumbersCounted(std::string_view text) {
  if (text.find_first_not_of("0123456789 \t") != std::string_view::npos) return 0;
  std::size_t num = 0;
  const std::vector<double> numbers = NumbersApart(text);
  for (const double number : numbers) {
    const double counted = numbers.front() + static_cast<double>(num);
    if (number != counted || numbers.front() > 1) return 0;
    ++num;
  }
  return num;
}

}  // namespace

std::vector<double> GridHeightsIn(std::string_view text) {
  constexpr std::string_view kBetween = " \t,;";
  // How consoles mark what came and what was sent.
  for (const std::string_view mark : {"<-", "->", "<", ">"}) {
    if (text.starts_with(mark)) text.remove_prefix(mark.size());
  }
  const std::size_t bar = text.find('|');
  std::string rest(bar == std::string_view::npos ? text : text.substr(bar + 1));
  std::ranges::replace_if(
      rest, [](char c) { return c == '[' || c == ']'; }, ' ');
  std::vector<double> heights_mm;
  for (std::size_t at = rest.find_first_not_of(kBetween); at != std::string::npos;) {
    const std::size_t end = std::min(rest.size(), rest.find_first_of(kBetween, at));
    std::string word = rest.substr(at, end - at);
    if (word.starts_with('+')) word.erase(0, 1);
    const auto height_mm = NumberOf(word);
    const bool is_missing = word == "." || word == "=======" || word == "nan";
    if (!height_mm && !is_missing) return {};
    heights_mm.push_back(height_mm.value_or(kUnknown));
    at = rest.find_first_not_of(kBetween, end);
  }
  return heights_mm;
}

std::optional<ConsoleGrid::Corners> ConsoleGrid::CornersOf(const ConsoleLine& line) {
  if (!line.text.starts_with('(')) return std::nullopt;
  std::size_t at = 0;
  const auto left = CornerAt(line.text, &at);
  const auto right = left ? CornerAt(line.text, &at) : std::nullopt;
  if (!right) return std::nullopt;
  return Corners{*left, *right};
}

bool ConsoleGrid::EndsBefore(const ConsoleLine& line) const {
  if (upper_ || rows_.size() < 2) return false;
  const std::size_t num_columns = rows_.front().second.size();
  if (NumbersCounted(line.text) == num_columns) return true;
  // Row 0 once more.
  if (!is_numbered_ || !LooksLikeRow(line.text)) return false;
  const std::vector<double> numbers = GridHeightsIn(line.text);
  return numbers.size() == num_columns + 1 && numbers.front() == 0 &&
         line.text.starts_with("0 ");
}

bool ConsoleGrid::Take(const ConsoleLine& line, int number) {
  const auto corners = CornersOf(line);
  if (corners) {
    // Above the rows two lines may stand, of indices and of coordinates: the last
    // counts.
    if (rows_.empty()) {
      upper_ = corners;
    } else if (!lower_) {
      lower_ = corners;
      is_whole_ = upper_.has_value();
    }
    return true;
  }
  if (line.lower.find("leveling grid") != std::string::npos ||
      line.lower.find("mesh bed level data") != std::string::npos) {
    End();
    if (lost_line_ == 0) lost_line_ = number;
    return true;
  }
  if (is_whole_ || (!upper_ && lost_line_ == 0) || !LooksLikeRow(line.text))
    return false;
  std::vector<double> heights_mm = GridHeightsIn(line.text);
  if (heights_mm.size() < 2) return line.text.find('|') != std::string_view::npos;
  // " 0 +0.059 +0.062": the row's number first.
  const bool is_numbered = !upper_ && line.text.find('|') == std::string_view::npos &&
                           heights_mm[0] == static_cast<double>(rows_.size());
  if (is_numbered) heights_mm.erase(heights_mm.begin());
  is_numbered_ |= is_numbered && rows_.empty();
  rows_.emplace_back(number, heights_mm);
  return true;
}

std::vector<GridHeight> ConsoleGrid::TakeHeights() {
  std::vector<GridHeight> all;
  if (!upper_) {
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      for (std::size_t c = 0; c < rows_[r].second.size(); ++c) {
        if (!Known(rows_[r].second[c])) continue;
        all.push_back({static_cast<double>(c),
                       static_cast<double>(r),
                       rows_[r].second[c],
                       rows_[r].first,
                       false});
      }
    }
    *this = ConsoleGrid();
    return all;
  }
  const auto [left, right] = *upper_;
  const double low_mm = lower_->first.second;
  const auto num_rows = static_cast<double>(rows_.size());
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const std::vector<double>& heights_mm = rows_[r].second;
    const auto num = static_cast<double>(heights_mm.size());
    for (std::size_t c = 0; c < heights_mm.size(); ++c) {
      if (!Known(heights_mm[c])) continue;
      const double along = static_cast<double>(c) / std::max(1.0, num - 1);
      const double down = static_cast<double>(r) / std::max(1.0, num_rows - 1);
      all.push_back({left.first + along * (right.first - left.first),
                     left.second + down * (low_mm - left.second),
                     heights_mm[c],
                     rows_[r].first});
    }
  }
  *this = ConsoleGrid();
  return all;
}

}  // namespace caltwin
