#include "sim/measure/import/spreadsheet.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <optional>
#include <utility>

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

// "(50, 50)" as "50" and "50"; nullopt of anything else.
std::optional<std::pair<std::string, std::string>> PlaceIn(std::string text) {
  if (text.starts_with('(') && text.ends_with(')'))
    text = text.substr(1, text.size() - 2);
  const std::size_t comma = text.find_first_of(",;/");
  if (comma == std::string::npos) return std::nullopt;
  std::string first = text.substr(0, comma), second = text.substr(comma + 1);
  second.erase(0, std::min(second.size(), second.find_first_not_of(' ')));
  if (!NumberOf(first) || !NumberOf(second)) return std::nullopt;
  return std::pair{first, second};
}

// A comma inside all cells of a column is no decimal mark where other cells have dots,
// or where a word over the column says that places stand there.
bool HoldsPlaces(const Split& split, std::size_t first, std::size_t column) {
  if (first + 1 >= split.records.size()) return false;
  bool has_dots = false;
  for (std::size_t i = first + 1; i < split.records.size(); ++i) {
    const CsvRecord& record = split.records[i];
    if (record.size() != split.num_fields || !PlaceIn(record[column].text))
      return false;
    for (const CsvField& field : record) has_dots |= HasDigitsAround(field.text, '.');
  }
  const std::string heading = PlainWord(split.records[first][column].text);
  return has_dots || heading == "corner" || heading == "point" || heading == "place" ||
         heading == "xy" || heading == "x,y" || heading == "position";
}

// The first that is no title: as many fields as most, and more than half of them
// filled where others are.
std::size_t FirstRecord(const Split& split) {
  std::size_t first = 0;
  const auto is_title = [&](const CsvRecord& record) {
    if (record.size() != split.num_fields) return true;
    const auto empty = static_cast<std::size_t>(std::ranges::count_if(
        record, [](const CsvField& field) { return field.text.empty(); }));
    const bool has_number = std::ranges::any_of(record, [](const CsvField& field) {
      return NumberOf(field.text).has_value() || NumberOf(field.text, ',').has_value();
    });
    return 2 * empty > record.size() && !has_number;
  };
  while (first + 1 < split.records.size() && is_title(split.records[first])) ++first;
  return first;
}

void PartPlaces(Split* split) {
  const std::size_t first = FirstRecord(*split);
  // Titles and nothing else.
  if (split->records[first].size() != split->num_fields) return;
  for (std::size_t column = 0; column < split->num_fields; ++column) {
    if (NumberOf(split->records[first][column].text) ||
        !HoldsPlaces(*split, first, column)) {
      continue;
    }
    for (std::size_t i = first; i < split->records.size(); ++i) {
      CsvRecord& record = split->records[i];
      const auto at = record.begin() + static_cast<std::ptrdiff_t>(column);
      const auto place = PlaceIn(record[column].text).value_or(std::pair{"x", "y"});
      CsvField second = record[column];
      record[column].text = i == first ? "x" : place.first;
      second.text = i == first ? "y" : place.second;
      record.insert(at + 1, second);
    }
    ++split->num_fields;
    return;
  }
}

}  // namespace

Spreadsheet ReadSpreadsheet(const std::string& text,
                            const std::string& name,
                            PlaceCells places) {
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
  if (places == PlaceCells::kParted) PartPlaces(&best);
  sheet.decimal = DecimalOf(best, name);
  const std::size_t first = FirstRecord(best);
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
