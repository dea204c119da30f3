#include "sim/measure/import/screw_table.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <vector>

#include <fmt/format.h>

#include "sim/measure/import/fields.h"
#include "sim/measure/import/positioning.h"

namespace caltwin {
namespace {

/// A line of numbers.
struct Numbers {
  std::vector<double> values{};
  TextLine line{};
};

std::vector<Numbers> LinesOfNumbers(const std::string& text, const std::string& name) {
  std::vector<Numbers> lines;
  Faults faults;
  for (TextLine& line : LinesOf(text)) {
    if (line.text.starts_with('#') || line.text.starts_with(';')) continue;
    Numbers numbers;
    for (const CsvField& word : line.words) {
      if (word.text.starts_with('#') || word.text.starts_with(';')) break;
      numbers.values.push_back(NumberIn(word, "a number of the table", name, &faults));
    }
    numbers.line = std::move(line);
    lines.push_back(std::move(numbers));
  }
  faults.ThrowIfAny();
  return lines;
}

// "z.comp", "screw_x.comp", "cnc-x.tab": the letter before the dot.
std::string AxisOfName(const std::string& name) {
  const std::string stem = std::filesystem::path(name).stem().string();
  if (stem.empty()) return "";
  const char last =
      static_cast<char>(std::tolower(static_cast<unsigned char>(stem.back())));
  const bool is_letter_alone =
      stem.size() == 1 ||
      std::isalpha(static_cast<unsigned char>(stem[stem.size() - 2])) == 0;
  return is_letter_alone && last >= 'x' && last <= 'z' ? std::string(1, last) : "";
}

Imported ReadComp(const std::vector<Numbers>& lines,
                  const std::string& name,
                  const ImportOptions& options) {
  Faults faults;
  double travel_mm = 0, off_mm = 0, size_mm = 0;
  for (const Numbers& line : lines) {
    if (line.values.size() != 3) {
      faults.Add(PlaceOf(line.line.words.front(), name),
                 fmt::format("{} numbers in this line", line.values.size()),
                 "NOMINAL FORWARD REVERSE");
      continue;
    }
    travel_mm = std::max(travel_mm, std::abs(line.values[0] - lines.front().values[0]));
    for (const std::size_t k : {1, 2}) {
      off_mm = std::max(off_mm, std::abs(line.values[k] - line.values[0]));
      size_mm = std::max(size_mm, std::abs(line.values[k]));
    }
  }
  faults.ThrowIfAny();
  // Positions follow the nominal ones, corrections do not.
  const bool is_trim = size_mm < off_mm && size_mm < travel_mm / 4;
  std::vector<PositionReading> readings;
  for (const int sense : {1, -1}) {
    for (const Numbers& line : lines) {
      const double read_mm = line.values[sense > 0 ? 1 : 2];
      readings.push_back({.run = 1,
                          .sense = static_cast<double>(sense),
                          .target_mm = line.values[0],
                          .value_mm = is_trim ? -read_mm : read_mm - line.values[0],
                          .place = PlaceOf(line.line.words.front(), name)});
    }
  }
  std::vector<std::string> assumed;
  const std::string axis = AxisOr(AxisOfName(name), options, &assumed);
  Imported imported = PositioningRows(readings, axis, options);
  imported.recognised = {
      fmt::format("a screw table of LinuxCNC, {} positions: {}",
                  lines.size(),
                  is_trim ? "corrections (COMP_FILE_TYPE 1), the error is minus them"
                          : "positions read (COMP_FILE_TYPE 0)")};
  imported.assumed = std::move(assumed);
  imported.assumed.emplace_back(
      "the table is what was measured without it; lengths are in mm (a machine in "
      "inches: "
      "import csv --map)");
  return imported;
}

// "24 -1448819": intervals and travel in counts; then a correction, or two, a line.
Imported ReadTab(const std::vector<Numbers>& lines,
                 const std::string& name,
                 const ImportOptions& options) {
  const Place place = PlaceOf(lines.front().line.words.front(), name);
  if (!options.step_mm) {
    throw InputError(
        place,
        "a Centroid table counts encoder counts, and nothing here says how "
        "long one is",
        "say it: --step-mm, lead / counts per turn");
  }
  const double intervals = lines.front().values[0];
  const double travel_mm = lines.front().values[1] * *options.step_mm;
  if (!(intervals >= 1) || travel_mm == 0) {
    throw InputError(place,
                     fmt::format("{:g} intervals over {:g} counts of travel",
                                 intervals,
                                 lines.front().values[1]),
                     "a Centroid table begins with both: 24 -1448819");
  }
  std::vector<PositionReading> readings;
  for (const int sense : {1, -1}) {
    for (std::size_t i = 1; i < lines.size(); ++i) {
      const std::vector<double>& values = lines[i].values;
      if (sense < 0 && values.size() < 2) continue;
      readings.push_back(
          {.run = 1,
           .sense = values.size() < 2 ? 0.0 : sense,
           .target_mm = travel_mm * static_cast<double>(i - 1) / intervals,
           .value_mm = -values[sense > 0 ? 0 : 1] * *options.step_mm,
           .place = PlaceOf(lines[i].line.words.front(), name)});
    }
  }
  std::vector<std::string> assumed;
  const std::string axis = AxisOr(AxisOfName(name), options, &assumed);
  Imported imported = PositioningRows(readings, axis, options);
  imported.recognised = {
      fmt::format("a screw table of a Centroid control, {:g} intervals", intervals)};
  imported.assumed = std::move(assumed);
  imported.assumed.emplace_back("the error is minus the correction");
  return imported;
}

}  // namespace

Imported ReadScrewTable(const std::string& text,
                        const std::string& name,
                        const ImportOptions& options) {
  const std::vector<Numbers> lines = LinesOfNumbers(text, name);
  constexpr std::size_t kFewest = 3;
  if (lines.size() < kFewest) {
    throw InputError({.file = name, .line = 1, .column = 1},
                     "no screw table stands here",
                     "a line a position: NOMINAL FORWARD REVERSE (LinuxCNC)");
  }
  const bool is_tab = lines[0].values.size() == 2 && lines[1].values.size() <= 2;
  Imported imported =
      is_tab ? ReadTab(lines, name, options) : ReadComp(lines, name, options);
  imported.is_deviation = imported.has_unit = true;
  return imported;
}

}  // namespace caltwin
