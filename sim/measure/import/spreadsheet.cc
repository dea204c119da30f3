#include "sim/measure/import/spreadsheet.h"

#include <algorithm>
#include <cctype>
#include <map>

#include <fmt/format.h>

#include "sim/measure/import/fields.h"

namespace caltwin {
namespace {

constexpr std::size_t kMostFaults = 100;

struct Split {
  std::vector<CsvRecord> records{};
  std::size_t num_fields = 0;  ///< That most records have.
  std::size_t num_agreeing = 0;
};

Split SplitAt(char separator, const std::string& text, const std::string& name) {
  Split split;
  Faults faults;
  if (separator == ' ') {
    for (TextLine& line : LinesOf(text)) {
      if (!line.text.starts_with('#')) split.records.push_back(std::move(line.words));
    }
  } else {
    CsvReader csv(text, name, &faults, separator);
    while (auto record = csv.Next()) split.records.push_back(std::move(*record));
    if (!faults.empty()) return {};
  }
  std::map<std::size_t, std::size_t> lines_with;
  for (const CsvRecord& record : split.records) ++lines_with[record.size()];
  for (const auto& [fields, lines] : lines_with) {
    if (fields < 2 || lines < split.num_agreeing) continue;
    split.num_fields = fields;
    split.num_agreeing = lines;
  }
  return split;
}

bool HasDigitsAround(const std::string& text, char mark) {
  const std::size_t at = text.find(mark);
  const auto is_digit = [&](std::size_t i) {
    return i < text.size() && std::isdigit(static_cast<unsigned char>(text[i])) != 0;
  };
  return at != std::string::npos && is_digit(at + 1) &&
         text.find_first_not_of("+-0123456789.,eE") == std::string::npos;
}

char DecimalOf(const Split& split, const std::string& name) {
  const CsvField* dotted = nullptr;
  for (const CsvRecord& record : split.records) {
    for (const CsvField& field : record) {
      if (dotted == nullptr && HasDigitsAround(field.text, '.')) dotted = &field;
    }
  }
  for (const CsvRecord& record : split.records) {
    for (const CsvField& field : record) {
      if (!HasDigitsAround(field.text, ',')) continue;
      if (dotted == nullptr) return ',';
      throw InputError(
          PlaceOf(field, name),
          fmt::format("'{}' has a comma in it, '{}' in line {} a dot: which is the "
                      "decimal mark?",
                      field.text,
                      dotted->text,
                      dotted->line),
          "save the sheet without separators of thousands, and with one decimal mark");
    }
  }
  return '.';
}

void CheckFields(const Split& split, std::size_t first, const std::string& name) {
  Faults faults;
  for (std::size_t i = first; i < split.records.size(); ++i) {
    const CsvRecord& record = split.records[i];
    if (record.size() == split.num_fields || faults.size() > kMostFaults) continue;
    faults.Add(
        PlaceOf(record.front(), name),
        fmt::format(
            "{} fields, where most lines have {}", record.size(), split.num_fields));
  }
  faults.ThrowIfAny();
}

}  // namespace

Spreadsheet ReadSpreadsheet(const std::string& text, const std::string& name) {
  Split best;
  Spreadsheet sheet;
  for (const char separator : {';', '\t', ',', ' '}) {
    Split split = SplitAt(separator, text, name);
    if (split.num_agreeing <= best.num_agreeing) continue;
    best = std::move(split);
    sheet.separator = separator;
  }
  if (best.num_agreeing < 1) {
    throw InputError({.file = name, .line = 1, .column = 1},
                     "no table stands here",
                     "columns apart by commas, semicolons, tabs or blanks, a line a "
                     "reading");
  }
  sheet.decimal = DecimalOf(best, name);
  std::size_t first = 0;
  while (best.records[first].size() != best.num_fields) ++first;
  CheckFields(best, first, name);
  const bool has_headings =
      std::ranges::none_of(best.records[first], [&](const CsvField& field) {
        return NumberOf(field.text, sheet.decimal).has_value();
      });
  if (has_headings) sheet.headings = best.records[first];
  const auto begin = best.records.begin() + static_cast<std::ptrdiff_t>(first) +
                     (has_headings ? 1 : 0);
  sheet.records.assign(std::make_move_iterator(begin),
                       std::make_move_iterator(best.records.end()));
  if (sheet.records.empty()) {
    throw InputError({.file = name}, "only a heading stands here, no readings");
  }
  return sheet;
}

}  // namespace caltwin
