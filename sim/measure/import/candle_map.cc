#include "sim/measure/import/candle_map.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "sim/measure/import/bed_touch.h"
#include "sim/measure/import/fields.h"

namespace caltwin {
namespace {

// "0;0;30;30"; empty: something else stands there too.
std::vector<double> AtSemicolons(std::string_view line) {
  std::vector<double> numbers;
  for (std::size_t from = 0; from <= line.size();) {
    const std::size_t end = std::min(line.size(), line.find(';', from));
    const auto number = NumberOf(line.substr(from, end - from));
    if (!number) return {};
    numbers.push_back(*number);
    from = end + 1;
  }
  return numbers;
}

constexpr double kMostPoints = 1000;

bool IsCount(double number) {
  return number >= 2 && number <= kMostPoints && number == std::round(number);
}

std::optional<CandleMap> MapFrom(const std::vector<TextLine>& lines, std::size_t i) {
  constexpr std::size_t kHead = 3;
  if (i + kHead >= lines.size()) return std::nullopt;
  const auto place = AtSemicolons(lines[i].text);
  const auto grid = AtSemicolons(lines[i + 1].text);
  const auto steps = AtSemicolons(lines[i + 2].text);
  if (place.size() != 4 || grid.size() != 4 || steps.size() != 3) return std::nullopt;
  if (!IsCount(grid[0]) || !IsCount(grid[1]) || place[2] <= 0 || place[3] <= 0) {
    return std::nullopt;
  }
  CandleMap map{.x_mm = place[0],
                .y_mm = place[1],
                .width_mm = place[2],
                .height_mm = place[3],
                .line = lines[i].line};
  for (std::size_t row = 0; row < static_cast<std::size_t>(grid[1]); ++row) {
    if (i + kHead + row >= lines.size()) return std::nullopt;
    auto heights_mm = AtSemicolons(lines[i + kHead + row].text);
    if (heights_mm.size() != static_cast<std::size_t>(grid[0])) return std::nullopt;
    map.heights_mm.push_back(std::move(heights_mm));
  }
  return map;
}

}  // namespace

bool CandleMap::IsLevel() const {
  return std::ranges::all_of(heights_mm, [&](const std::vector<double>& row) {
    return std::ranges::all_of(
        row, [&](double height) { return height == heights_mm[0][0]; });
  });
}

std::size_t CandleMap::num() const {
  return heights_mm.size() * heights_mm.front().size();
}

std::optional<CandleMap> CandleMapIn(const std::string& text) {
  const std::vector<TextLine> lines = LinesOf(text);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (auto map = MapFrom(lines, i)) return map;
  }
  return std::nullopt;
}

void TellLevelMap(const CandleMap& map,
                  const std::vector<double>& touched_mm,
                  Imported* imported) {
  if (!map.IsLevel()) return;
  std::string against;
  if (touched_mm.size() > 1) {
    const auto [low, high] = std::ranges::minmax(touched_mm);
    if (high == low) return;
    against = fmt::format(
        ", while the {} touches of this console differ by {:.3f} mm: the map was not "
        "made of them. A sender that takes the wrong field of the probe's report (the "
        "last, where the controller has more than three axes) writes such a map. The "
        "probe is in order",
        touched_mm.size(),
        high - low);
  }
  imported->notes.push_back(
      {.kind = FileNote::Kind::kElsewhere,
       .what = "file",
       .sentence = fmt::format(
           "Line {}: all {} heights of this map are {:g} to the last digit, which no "
           "probe reads{}. Do not use it; build the firmware with the axes that the "
           "sender knows, or use another sender",
           map.line,
           map.num(),
           map.heights_mm[0][0],
           against)});
}

Imported ReadCandleMap(const std::string& text,
                       const std::string& name,
                       const ImportOptions& options) {
  const auto map = CandleMapIn(text);
  if (!map) {
    throw InputError({.file = name, .line = 1, .column = 1},
                     "no height map stands here",
                     "x;y;width;height, columns;rows;from;to, three numbers, then the "
                     "heights");
  }
  Imported imported{
      .recognised = {fmt::format("a height map of Candle: {} touches", map->num())},
      .assumed = {"the first line of heights is that of the lowest y"},
      .has_unit = true};
  const auto num_rows = static_cast<double>(map->heights_mm.size() - 1);
  const auto num_columns = static_cast<double>(map->heights_mm[0].size() - 1);
  for (std::size_t j = 0; j < map->heights_mm.size(); ++j) {
    for (std::size_t i = 0; i < map->heights_mm[j].size(); ++i) {
      const double x_mm =
          map->x_mm + map->width_mm * static_cast<double>(i) / num_columns;
      const double y_mm =
          map->y_mm + map->height_mm * static_cast<double>(j) / num_rows;
      Row row = BedTouchRow(
          options.campaign.empty() ? "map" : options.campaign,
          x_mm,
          y_mm,
          map->heights_mm[j][i],
          {.file = name, .line = map->line + 3 + static_cast<int>(j), .column = 1});
      imported.table.rows.push_back(std::move(row));
    }
  }
  TellLevelMap(*map, {}, &imported);
  return imported;
}

}  // namespace caltwin
