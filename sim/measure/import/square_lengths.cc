#include "sim/measure/import/square_lengths.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string_view>

#include <fmt/format.h>

#include "sim/measure/import/fields.h"
#include "sim/measure/row_flags.h"

namespace caltwin {
namespace {

/// A corner of a unit square: 0 or 1 along x and y.
struct Corner {
  int x = 0, y = 0;
};
struct Line {
  std::size_t column = 0;
  Corner from{}, to{};
  const NamedUnit* unit = nullptr;

  bool is_diagonal() const { return from.x != to.x && from.y != to.y; }
};

std::optional<Line> NamedLine(const std::string& token) {
  static const std::map<std::string, Line> kLines = {
      {"ac", {.from = {0, 0}, .to = {1, 1}}},
      {"bd", {.from = {0, 1}, .to = {1, 0}}},
      {"ab", {.from = {0, 0}, .to = {0, 1}}},
      {"bc", {.from = {0, 1}, .to = {1, 1}}},
      {"cd", {.from = {1, 1}, .to = {1, 0}}},
      {"dc", {.from = {1, 0}, .to = {1, 1}}},
      {"ad", {.from = {0, 0}, .to = {1, 0}}},
      {"da", {.from = {1, 0}, .to = {0, 0}}}};
  const auto found = kLines.find(token);
  return found == kLines.end() ? std::nullopt : std::optional(found->second);
}

// The senses along x and y that words name, in their order: "front left rear right".
void TakeSide(const std::string& token, std::vector<int>* xs, std::vector<int>* ys) {
  if (token == "left" || token == "links" || token == "gauche") xs->push_back(0);
  if (token == "right" || token == "rechts" || token == "droite") xs->push_back(1);
  if (token == "front" || token == "vorne" || token == "avant" || token == "near" ||
      token == "bottom" || token == "lower")
    ys->push_back(0);
  if (token == "rear" || token == "hinten" || token == "back" || token == "far" ||
      token == "top" || token == "upper") {
    ys->push_back(1);
  }
  // "fl", "rr", "tl": two letters of a corner.
  const bool is_corner =
      token.size() == 2 &&
      std::string_view("fnrbtu").find(token[0]) != std::string_view::npos &&
      (token[1] == 'l' || token[1] == 'r');
  if (!is_corner) return;
  xs->push_back(token[1] == 'r' ? 1 : 0);
  ys->push_back(token[0] == 'f' || token[0] == 'n' ? 0 : token[0] == 'b' ? 2 : 1);
}

std::optional<Line> LineOf(const std::string& heading) {
  const std::vector<std::string> tokens = TokensOf(heading);
  std::vector<int> xs, ys;
  for (std::size_t i = 0; i < tokens.size(); ++i) {
    if (const auto named = NamedLine(tokens[i])) return named;
    // "corner A to C"
    const bool is_to = i + 2 < tokens.size() && tokens[i].size() == 1 &&
                       tokens[i + 1] == "to" && tokens[i + 2].size() == 1;
    if (is_to) {
      if (const auto named = NamedLine(tokens[i] + tokens[i + 2])) return named;
    }
    TakeSide(tokens[i], &xs, &ys);
  }
  // A "b" is the back where fronts are named, else the bottom.
  for (int& y : ys) {
    if (y == 2) y = std::ranges::find(ys, 0) != ys.end() ? 1 : 0;
  }
  const bool is_diagonal = std::ranges::any_of(
      tokens, [](const std::string& token) { return token.starts_with("diag"); });
  if (xs.size() == 2 && ys.size() == 2 && xs[0] != xs[1] && ys[0] != ys[1])
    return Line{.from = {xs[0], ys[0]}, .to = {xs[1], ys[1]}};
  if (is_diagonal && heading.find('\\') != std::string::npos) return NamedLine("bd");
  if (is_diagonal && heading.find('/') != std::string::npos) return NamedLine("ac");
  if (is_diagonal) return std::nullopt;
  if (xs.size() == 1 && ys.empty()) return Line{.from = {xs[0], 0}, .to = {xs[0], 1}};
  if (ys.size() == 1 && xs.empty()) return Line{.from = {0, ys[0]}, .to = {1, ys[0]}};
  for (const std::string& token : tokens) {
    if (token == "width" || token == "x") return NamedLine("ad");
    if (token == "depth" || token == "y") return NamedLine("ab");
  }
  return std::nullopt;
}

double Value_mm(const CsvRecord& record, const Line& line, char decimal) {
  const auto number = NumberOf(record[line.column].text, decimal);
  if (!number) return kUnknown;
  return line.unit != nullptr ? line.unit->convert(*number) : *number;
}

// The mean of what is known of the lines that are chosen; kUnknown of none.
template <typename Chosen>
double MeanOf_mm(const Spreadsheet& sheet,
                 const std::vector<Line>& lines,
                 const Chosen& is_chosen) {
  double sum_mm = 0, num = 0;
  for (const CsvRecord& record : sheet.records) {
    for (const Line& line : lines) {
      const double value_mm = Value_mm(record, line, sheet.decimal);
      if (!is_chosen(line) || !Known(value_mm)) continue;
      sum_mm += value_mm;
      num += 1;
    }
  }
  return num > 0 ? sum_mm / num : kUnknown;
}

}  // namespace

void AddLength(const std::string& campaign,
               const std::string& line,
               const Corners& corners,
               double read_mm,
               const Place& place,
               Imported* imported) {
  const auto& [from_mm, to_mm] = corners;
  double length_mm = 0;
  for (std::size_t k = 0; k < 3; ++k) length_mm += std::pow(to_mm[k] - from_mm[k], 2);
  length_mm = std::sqrt(length_mm);
  Row row{.campaign = campaign,
          .setup = line,
          .flag = std::string(kLengthFlag),
          .place = place};
  for (std::size_t k = 0; k < 3; ++k) row.n[k] = (to_mm[k] - from_mm[k]) / length_mm;
  row.cmd_mm = from_mm;
  imported->table.rows.push_back(row);
  row.cmd_mm = to_mm;
  row.value_mm = read_mm - length_mm;
  imported->table.rows.push_back(row);
}

namespace {

// Lines of a square one below the other, their names in the first column, each measured
// once or more, as the table that has a line of its own for each time.
std::optional<Spreadsheet> Turned(const Spreadsheet& sheet) {
  if (sheet.headings.size() < 2) return std::nullopt;
  Spreadsheet turned;
  turned.decimal = sheet.decimal;
  std::vector<const CsvRecord*> lines;
  for (const CsvRecord& record : sheet.records) {
    if (!LineOf(record[0].text) || !NumberOf(record[1].text, sheet.decimal)) continue;
    turned.headings.push_back(record[0]);
    lines.push_back(&record);
  }
  if (lines.size() < 2) return std::nullopt;
  for (std::size_t k = 1; k < sheet.headings.size(); ++k) {
    CsvRecord record;
    for (const CsvRecord* line : lines) record.push_back((*line)[k]);
    turned.records.push_back(std::move(record));
  }
  return turned;
}

bool ReadLines(const Spreadsheet& sheet, const std::string& name, Imported* imported) {
  std::vector<Line> lines;
  bool has_rising = false, has_falling = false;
  for (std::size_t i = 0; i < sheet.headings.size(); ++i) {
    auto line = LineOf(sheet.headings[i].text);
    if (!line || !AreNumbers(sheet, i)) continue;
    line->column = i;
    line->unit = UnitInHeading(sheet.headings[i].text, Quantity::kLength);
    if (line->is_diagonal()) {
      (line->from.x == line->from.y ? has_rising : has_falling) = true;
    }
    lines.push_back(*line);
  }
  if (!has_rising || !has_falling) return false;
  double width_mm = MeanOf_mm(
      sheet, lines, [](const Line& line) { return line.from.y == line.to.y; });
  double depth_mm = MeanOf_mm(
      sheet, lines, [](const Line& line) { return line.from.x == line.to.x; });
  const double diagonal_mm =
      MeanOf_mm(sheet, lines, [](const Line& line) { return line.is_diagonal(); });
  if (!Known(width_mm))
    width_mm = Known(depth_mm) ? depth_mm : diagonal_mm / std::sqrt(2.0);
  if (!Known(depth_mm)) depth_mm = width_mm;
  if (!(width_mm > 0) || !(depth_mm > 0)) return false;
  int number = 0;
  for (const CsvRecord& record : sheet.records) {
    ++number;
    for (const Line& line : lines) {
      const double value_mm = Value_mm(record, line, sheet.decimal);
      if (!Known(value_mm)) continue;
      AddLength("squares",
                fmt::format("{}_{}", number, line.column + 1),
                {{line.from.x * width_mm, line.from.y * depth_mm, 0},
                 {line.to.x * width_mm, line.to.y * depth_mm, 0}},
                value_mm,
                PlaceOf(record[line.column], name),
                imported);
    }
  }
  imported->recognised.push_back(
      fmt::format("diagonals and sides of {} square{} in X and Y",
                  sheet.records.size(),
                  sheet.records.size() == 1 ? "" : "s"));
  imported->has_unit = true;
  return true;
}

}  // namespace

bool ReadSquares(const Spreadsheet& sheet,
                 const std::string& name,
                 Imported* imported) {
  if (ReadLines(sheet, name, imported)) return true;
  const auto turned = Turned(sheet);
  return turned && ReadLines(*turned, name, imported);
}

}  // namespace caltwin
