#include "sim/measure/import/rrf_heightmap.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "sim/measure/import/bed_touch.h"
#include "sim/measure/import/fields.h"

namespace caltwin {
namespace {

constexpr double kFarthest_mm = 10'000;
constexpr double kMostCount = 200;

CsvRecord FieldsOf(const TextLine& line) {
  CsvRecord fields;
  std::size_t at = 0;
  while (true) {
    const std::size_t comma = std::min(line.text.size(), line.text.find(',', at));
    const std::string_view whole = line.text.substr(at, comma - at);
    const std::size_t first = std::min(whole.size(), whole.find_first_not_of(" \t"));
    const std::size_t last = whole.find_last_not_of(" \t");
    fields.push_back(
        {.text = std::string(last == std::string_view::npos
                                 ? ""
                                 : whole.substr(first, last + 1 - first)),
         .line = line.line,
         .column = static_cast<int>(at + first) + line.words.front().column});
    if (comma == line.text.size()) return fields;
    at = comma + 1;
  }
}

/// Where the heights lie.
struct Grid {
  std::array<double, 2> min_mm{}, spacing_mm{};
  std::array<std::size_t, 2> count{};
};

class MapReader {
 public:
  MapReader(const std::string& text, std::string name)
      : name_(std::move(name)), lines_(LinesOf(text)) {}

  Imported Read(const ImportOptions& options) {
    FindTable();
    ReadGrid();
    ReadHeights(options);
    faults_.ThrowIfAny();
    if (imported_.table.rows.empty()) {
      throw InputError(at_line(table_), "no point of this map was probed");
    }
    imported_.recognised = {
        fmt::format("a height map, {} x {}: {} points probed, {} not",
                    grid_.count[0],
                    grid_.count[1],
                    imported_.table.rows.size(),
                    num_missing_)};
    imported_.assumed = {"a bare 0 was not probed; a height is the bed's, + is up"};
    return std::move(imported_);
  }

 private:
  Place at_line(std::size_t line) const {
    return {.file = name_, .line = lines_.empty() ? 1 : lines_[line].line, .column = 1};
  }

  void FindTable() {
    for (std::size_t i = 0; i + 1 < lines_.size(); ++i) {
      const bool is_names =
          lines_[i].text.starts_with("xmin,") || lines_[i].text.starts_with("axis0,");
      if (!is_names) continue;
      table_ = i;
      return;
    }
    throw InputError(at_line(0),
                     "no height map stands here",
                     "it has a line xmin,xmax,ymin,ymax,radius,... or axis0,axis1,... "
                     "and a line of their numbers below");
  }

  void ReadGrid() {
    const CsvRecord names = FieldsOf(lines_[table_]);
    const CsvRecord values = FieldsOf(lines_[table_ + 1]);
    if (names.size() != values.size()) {
      throw InputError(
          at_line(table_ + 1),
          fmt::format("{} numbers below {} names", values.size(), names.size()));
    }
    const auto number = [&](const std::string& old_name,
                            const std::string& new_name,
                            double min,
                            double max) -> double {
      for (std::size_t i = 0; i < names.size(); ++i) {
        if (names[i].text != old_name && names[i].text != new_name) continue;
        const double value = NumberIn(values[i], names[i].text, name_, &faults_);
        if (value >= min && value <= max) return value;
        faults_.Add(
            PlaceOf(values[i], name_),
            fmt::format(
                "{} = {:g} is not in {:g} .. {:g}", names[i].text, value, min, max));
        return min;
      }
      faults_.Add(at_line(table_), fmt::format("{} is not there", old_name));
      return min;
    };
    for (std::size_t i = 0; i < 2; ++i) {
      const std::string axis(1, "xy"[i]);
      const std::string index = std::to_string(i);
      grid_.min_mm[i] =
          number(axis + "min", "min" + index, -kFarthest_mm, kFarthest_mm);
      grid_.spacing_mm[i] =
          number(axis + "spacing", "spacing" + index, 1e-3, kFarthest_mm);
      grid_.count[i] =
          static_cast<std::size_t>(number(axis + "num", "num" + index, 1, kMostCount));
    }
    faults_.ThrowIfAny();
  }

  void ReadHeights(const ImportOptions& options) {
    const std::size_t first = table_ + 2;
    if (lines_.size() != first + grid_.count[1]) {
      throw InputError(
          at_line(lines_.size() - 1),
          fmt::format(
              "{} lines of heights, not {}", lines_.size() - first, grid_.count[1]));
    }
    for (std::size_t y = 0; y < grid_.count[1]; ++y) {
      const CsvRecord heights = FieldsOf(lines_[first + y]);
      if (heights.size() != grid_.count[0]) {
        faults_.Add(
            at_line(first + y),
            fmt::format(
                "{} heights in a line, not {}", heights.size(), grid_.count[0]));
        continue;
      }
      for (std::size_t x = 0; x < heights.size(); ++x) Add(heights[x], x, y, options);
    }
  }

  void Add(const CsvField& height,
           std::size_t x,
           std::size_t y,
           const ImportOptions& options) {
    if (height.text == "0") {
      ++num_missing_;
      return;
    }
    imported_.table.rows.push_back(
        BedTouchRow(options.campaign.empty() ? "heightmap" : options.campaign,
                    grid_.min_mm[0] + grid_.spacing_mm[0] * static_cast<double>(x),
                    grid_.min_mm[1] + grid_.spacing_mm[1] * static_cast<double>(y),
                    NumberIn(height, "a height", name_, &faults_),
                    PlaceOf(height, name_)));
  }

  std::string name_;
  std::vector<TextLine> lines_;
  std::size_t table_ = 0;
  Grid grid_;
  std::size_t num_missing_ = 0;
  Faults faults_;
  Imported imported_;
};

}  // namespace

Imported ReadRrfHeightmap(const std::string& text,
                          const std::string& name,
                          const ImportOptions& options) {
  return MapReader(text, name).Read(options);
}

}  // namespace caltwin
