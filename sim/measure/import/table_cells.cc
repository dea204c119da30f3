#include <algorithm>
#include <cctype>
#include <string>

#include "sim/measure/import/fields.h"
#include "sim/measure/import/table_columns.h"

namespace caltwin {
namespace {

// The unit behind the number in every cell of a column; empty: not the same in all, or
// none.
std::string UnitInCells(const Spreadsheet& sheet, std::size_t column) {
  std::string unit;
  for (const CsvRecord& record : sheet.records) {
    const std::string& text = record[column].text;
    const std::size_t end = text.find_last_of("0123456789.");
    if (text.empty() || end == std::string::npos || end + 1 == text.size()) return "";
    std::string own = text.substr(end + 1);
    own.erase(0, std::min(own.size(), own.find_first_not_of(' ')));
    if (!NumberOf(text.substr(0, end + 1), sheet.decimal)) return "";
    if (!unit.empty() && own != unit) return "";
    unit = own;
  }
  for (const Quantity quantity :
       {Quantity::kLength, Quantity::kTemperature, Quantity::kTime, Quantity::kFeed}) {
    if (UnitInHeading("value [" + unit + "]", quantity) != nullptr) return unit;
  }
  return "";
}

// "X+1" and "y -0.5": a letter and a move.
bool IsMoveOfAxis(const std::string& text, char decimal) {
  if (text.size() < 2) return false;
  const char letter =
      static_cast<char>(std::tolower(static_cast<unsigned char>(text[0])));
  std::string rest = text.substr(1);
  rest.erase(0, std::min(rest.size(), rest.find_first_not_of(' ')));
  if (rest.starts_with('+')) rest.erase(0, 1);
  return letter >= 'x' && letter <= 'z' && NumberOf(rest, decimal).has_value();
}

// A column of such moves becomes an axis, a command and a sense.
void PartMoves(std::size_t column, Spreadsheet* sheet) {
  const auto at = [&](CsvRecord& record) {
    return record.begin() + static_cast<std::ptrdiff_t>(column);
  };
  for (CsvRecord& record : sheet->records) {
    CsvField field = record[column];
    std::string move = field.text.substr(1);
    move.erase(0, std::min(move.size(), move.find_first_not_of(' ')));
    const bool is_minus = move.starts_with('-');
    if (move.starts_with('+')) move.erase(0, 1);
    record[column].text = field.text.substr(0, 1);
    field.text = is_minus ? "-" : "+";
    record.insert(at(record) + 1, field);
    field.text = move;
    record.insert(at(record) + 1, field);
  }
  CsvField heading = sheet->headings[column];
  const std::string was = heading.text;
  sheet->headings[column].text = "axis";
  heading.text = "sense";
  sheet->headings.insert(at(sheet->headings) + 1, heading);
  heading.text = "jog told (" + was + ")";
  sheet->headings.insert(at(sheet->headings) + 1, heading);
}

}  // namespace

void PartCells(Spreadsheet* sheet) {
  if (sheet->headings.empty()) return;
  for (std::size_t i = 0; i < sheet->headings.size(); ++i) {
    const bool are_moves =
        std::ranges::all_of(sheet->records, [&](const CsvRecord& record) {
          return IsMoveOfAxis(record[i].text, sheet->decimal);
        });
    if (are_moves) {
      PartMoves(i, sheet);
      continue;
    }
    const std::string unit = UnitInCells(*sheet, i);
    if (unit.empty()) continue;
    for (CsvRecord& record : sheet->records) {
      std::string& text = record[i].text;
      text.erase(text.find_last_of("0123456789.") + 1);
    }
    sheet->headings[i].text += " [" + unit + "]";
  }
}

}  // namespace caltwin
