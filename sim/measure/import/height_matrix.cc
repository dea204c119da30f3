#include "sim/measure/import/height_matrix.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "sim/measure/import/bed_touch.h"
#include "sim/measure/import/fields.h"

namespace caltwin {
namespace {

constexpr std::size_t kFewest = 3;        // Places each way.
constexpr std::size_t kLongestLabel = 4;  // "X:", "y\x".
constexpr double kEven = 0.03;            // Of a spacing: places are rounded.

// The numbers of a line behind a short label; empty where something else stands there.
std::vector<double> NumbersIn(const TextLine& line) {
  std::vector<double> numbers;
  for (std::size_t i = 0; i < line.words.size(); ++i) {
    std::string_view word = line.words[i].text;
    while (!word.empty() && (word.back() == ',' || word.back() == ';')) {
      word.remove_suffix(1);
    }
    if (const auto number = NumberOf(word)) {
      numbers.push_back(*number);
    } else if (i > 0 || word.size() > kLongestLabel) {
      return {};
    }
  }
  return numbers;
}

bool IsEvenlySpaced(const std::vector<double>& places_mm) {
  if (places_mm.size() < kFewest) return false;
  const double step_mm = (places_mm.back() - places_mm.front()) /
                         static_cast<double>(places_mm.size() - 1);
  if (step_mm == 0) return false;
  for (std::size_t i = 0; i < places_mm.size(); ++i) {
    const double even_mm = places_mm.front() + step_mm * static_cast<double>(i);
    if (std::abs(places_mm[i] - even_mm) > kEven * std::abs(step_mm)) return false;
  }
  return true;
}

// 0 1 2 .. or 1 2 3 ..
bool AreCounted(const std::vector<double>& places) {
  const bool begins = places.front() == 0 || places.front() == 1;
  return begins && places[1] == places[0] + 1;
}

std::optional<HeightMatrix> MatrixFrom(const std::vector<TextLine>& lines,
                                       std::size_t first) {
  HeightMatrix matrix{.x_mm = NumbersIn(lines[first]), .line = lines[first].line};
  if (!IsEvenlySpaced(matrix.x_mm)) return std::nullopt;
  for (std::size_t i = first + 1; i < lines.size(); ++i) {
    std::vector<double> numbers = NumbersIn(lines[i]);
    if (numbers.size() != matrix.x_mm.size() + 1) break;
    std::vector<double> y_mm = matrix.y_mm;
    y_mm.push_back(numbers.front());
    if (y_mm.size() >= kFewest && !IsEvenlySpaced(y_mm)) break;
    matrix.y_mm = std::move(y_mm);
    matrix.heights_mm.emplace_back(numbers.begin() + 1, numbers.end());
  }
  if (!IsEvenlySpaced(matrix.y_mm)) return std::nullopt;
  // Numbers of points and no places: others read those.
  if (AreCounted(matrix.x_mm) && AreCounted(matrix.y_mm)) return std::nullopt;
  return matrix;
}

}  // namespace

std::optional<HeightMatrix> HeightMatrixIn(const std::string& text) {
  const std::vector<TextLine> lines = LinesOf(text);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (auto matrix = MatrixFrom(lines, i)) return matrix;
  }
  return std::nullopt;
}

Imported ReadHeightMatrix(const std::string& text,
                          const std::string& name,
                          const ImportOptions& options) {
  const auto matrix = HeightMatrixIn(text);
  if (!matrix) {
    throw InputError({.file = name, .line = 1, .column = 1},
                     "no matrix of heights stands here",
                     "a line of places along x, then a line for each y: its place and "
                     "the heights");
  }
  Imported imported{
      .recognised = {fmt::format(
          "a matrix of heights, {} places along x and {} along y",
          matrix->x_mm.size(),
          matrix->y_mm.size())},
      .assumed = {"x runs across and y down; places and heights are in mm, + is up"},
      .has_unit = true};
  for (std::size_t j = 0; j < matrix->y_mm.size(); ++j) {
    for (std::size_t i = 0; i < matrix->x_mm.size(); ++i) {
      imported.table.rows.push_back(BedTouchRow(
          options.campaign.empty() ? "map" : options.campaign,
          matrix->x_mm[i],
          matrix->y_mm[j],
          matrix->heights_mm[j][i],
          {.file = name, .line = matrix->line + 1 + static_cast<int>(j), .column = 1}));
    }
  }
  return imported;
}

}  // namespace caltwin
