#include "sim/measure/import/table_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

#include "sim/measure/import/fields.h"

namespace caltwin {
namespace {

// Digits behind the decimal mark, of the cell that has most.
std::size_t DecimalsOf(const Spreadsheet& sheet, std::size_t column) {
  std::size_t most = 0;
  for (const CsvRecord& record : sheet.records) {
    const std::string& text = record[column].text;
    const std::size_t mark = text.find(sheet.decimal);
    if (mark != std::string::npos) most = std::max(most, text.size() - mark - 1);
  }
  return most;
}

// 1, 2, 3 ... or 0, 1, 2 ...: lines that were numbered.
bool IsCount(const Spreadsheet& sheet, std::size_t column) {
  constexpr std::size_t kFewest = 3;
  const std::vector<double> numbers = NumbersOf(sheet, column);
  if (numbers.size() < kFewest || numbers.size() != sheet.records.size()) return false;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (numbers[i] != numbers[0] + static_cast<double>(i)) return false;
  }
  return numbers[0] == 0 || numbers[0] == 1;
}

bool IsYesOrNo(const Spreadsheet& sheet, std::size_t column) {
  constexpr std::array<std::string_view, 6> kWords = {
      "yes", "no", "true", "false", "y", "n"};
  bool has_any = false;
  for (const CsvRecord& record : sheet.records) {
    const std::string word = PlainWord(record[column].text);
    if (word.empty()) continue;
    has_any = true;
    if (std::ranges::find(kWords, word) == kWords.end()) return false;
  }
  return has_any;
}

/// Gives parts to the columns whose headings say nothing, one after the other.
class PartsByNumbers {
 public:
  PartsByNumbers(const Spreadsheet& sheet,
                 std::vector<TableColumn>* columns,
                 std::vector<std::string>* taken)
      : sheet_(sheet), columns_(*columns), taken_(*taken) {}

  void Take() {
    TakeReadColumns();
    TakeWords();
    TakePlaces();
    TakeCounts();
    const bool has_read = Has(Part::kActual) || Has(Part::kDeviation);
    const bool has_places = HasPlace(0) && HasPlace(1) && !Has(Part::kCommanded);
    const bool has_told = Has(Part::kCommanded) || Has(Part::kPosition);
    const bool has_heights =
        !Has(Part::kCommanded) && !has_read && (Has(Part::kHeight) || HasPlace(2));
    TakeOpen();
    if (open_.empty() || (has_read && has_told) || has_heights) return;
    if (has_places && !has_read) return Give(open_.front(), Part::kHeight, "a height");
    if (has_told) {
      for (TableColumn* column : open_) Give(column, Part::kActual, "read");
      return;
    }
    const bool is_told_apart = Has(Part::kSense) || Has(Part::kHome) ||
                               Has(Part::kEvent) || Has(Part::kTime) ||
                               Has(Part::kTemperature);
    if (has_read && is_told_apart) return;
    // A line or two of numbers that nothing names may be anything.
    constexpr std::size_t kFewestLines = 3;
    if (!has_read && sheet_.records.size() < kFewestLines) return;
    const bool is_alone = !has_read && (open_.size() == 1 || AreAlike() || AreApart());
    if (!is_alone) {
      TableColumn* told =
          *std::ranges::min_element(open_, {}, [&](TableColumn* column) {
            return DecimalsOf(sheet_, column->index);
          });
      Give(told, Part::kCommanded, "told");
      std::erase(open_, told);
    }
    if (has_read) return;
    for (TableColumn* column : open_) Give(column, Part::kActual, "read");
  }

 private:
  bool Has(Part part) const {
    return std::ranges::find(columns_, part, &TableColumn::part) != columns_.end();
  }
  bool HasPlace(int axis) const {
    return std::ranges::any_of(columns_, [&](const TableColumn& column) {
      return column.part == Part::kPosition && column.axis == axis;
    });
  }

  // Beside a column of nominal sizes, plain columns "x", "Y (mm)" and "outside" are
  // what was read.
  void TakeReadColumns() {
    const bool has_nominal =
        std::ranges::any_of(columns_, [](const TableColumn& column) {
          return column.part == Part::kCommanded && column.axis < 0;
        });
    if (!has_nominal || Has(Part::kActual) || Has(Part::kDeviation)) return;
    for (TableColumn& column : columns_) {
      for (const std::string& token : TokensOf(HeadingOf(column))) {
        if (IsSideWord(token)) column.side = token;
      }
      const bool is_letter = column.axis >= 0 && (column.part == Part::kPosition ||
                                                  column.part == Part::kHeight);
      if (is_letter || !column.side.empty()) column.part = Part::kActual;
    }
  }

  // Three columns without headings, the last of which hardly varies: x, y and a height.
  void TakePlaces() {
    constexpr double kFlat = 0.2;
    constexpr std::size_t kFewest = 4;
    if (!sheet_.headings.empty() || columns_.size() != 3 ||
        sheet_.records.size() < kFewest) {
      return;
    }
    std::array<double, 3> ranges{};
    for (std::size_t k = 0; k < 3; ++k) {
      if (!AreNumbers(sheet_, k)) return;
      const auto [low, high] = std::ranges::minmax(NumbersOf(sheet_, k));
      ranges[k] = high - low;
    }
    if (ranges[2] > kFlat * std::min(ranges[0], ranges[1])) return;
    for (int k = 0; k < 3; ++k) {
      TableColumn& column = columns_[static_cast<std::size_t>(k)];
      column.axis = k;
      column.part = k < 2 ? Part::kPosition : Part::kHeight;
    }
    taken_.emplace_back("the columns are x, y and a height: no heading says it");
  }

  // Of two columns that a command may be, one that counts lines is none.
  void TakeCounts() {
    const auto is_plain = [](const TableColumn& column) {
      return column.part == Part::kCommanded && column.axis < 0;
    };
    if (std::ranges::count_if(columns_, is_plain) < 2) return;
    for (TableColumn& column : columns_) {
      if (is_plain(column) && IsCount(sheet_, column.index)) column.part = Part::kRun;
    }
  }

  void TakeWords() {
    for (TableColumn& column : columns_) {
      if (column.part != Part::kNone || AreNumbers(sheet_, column.index)) continue;
      column.part = IsYesOrNo(sheet_, column.index) ? Part::kEvent : Part::kSetup;
    }
  }

  // Numbers whose headings say nothing; where two of them have a unit of length, only
  // those that have one.
  void TakeOpen() {
    std::size_t num_with_unit = 0;
    for (TableColumn& column : columns_) {
      if (column.part != Part::kNone || IsOfSteps(column)) continue;
      open_.push_back(&column);
      num_with_unit += UnitOf(column) != nullptr ? 1 : 0;
    }
    std::erase_if(open_, [&](TableColumn* column) {
      const bool is_plain = UnitOf(*column) == nullptr;
      const bool is_count =
          is_plain && columns_.size() > 1 && IsCount(sheet_, column->index);
      if (is_count) column->part = Part::kRun;
      return is_count || (is_plain && num_with_unit >= 2);
    });
    for (TableColumn* column : open_) {
      if (column->unit == nullptr) column->unit = UnitOf(*column);
    }
  }

  // Counted steps are no lengths, and neither are speeds of turning or currents.
  bool IsOfSteps(const TableColumn& column) const {
    constexpr std::array<std::string_view, 11> kWords = {"steps",
                                                         "pulses",
                                                         "counts",
                                                         "ticks",
                                                         "rpm",
                                                         "hz",
                                                         "khz",
                                                         "volts",
                                                         "amps",
                                                         "percent",
                                                         "turns"};
    const std::vector<std::string> tokens = TokensOf(HeadingOf(column));
    return UnitOf(column) == nullptr &&
           std::ranges::any_of(tokens, [&](const std::string& token) {
             return std::ranges::find(kWords, token) != kWords.end();
           });
  }

  // Whether two columns go together, as a command and what followed it do.
  bool GoTogether(std::size_t one, std::size_t other) const {
    constexpr double kLeast = 0.7;
    const std::vector<double> a = NumbersOf(sheet_, one), b = NumbersOf(sheet_, other);
    if (a.size() != b.size() || a.size() < 3) return true;
    double mean_a = 0, mean_b = 0, ab = 0, aa = 0, bb = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      mean_a += a[i] / static_cast<double>(a.size());
      mean_b += b[i] / static_cast<double>(a.size());
    }
    for (std::size_t i = 0; i < a.size(); ++i) {
      ab += (a[i] - mean_a) * (b[i] - mean_b);
      aa += std::pow(a[i] - mean_a, 2);
      bb += std::pow(b[i] - mean_b, 2);
    }
    return aa == 0 || bb == 0 || std::abs(ab) > kLeast * std::sqrt(aa * bb);
  }

  // Columns none of which follows another: readings of several things.
  bool AreApart() const {
    for (std::size_t i = 0; i < open_.size(); ++i) {
      for (std::size_t k = i + 1; k < open_.size(); ++k) {
        if (GoTogether(open_[i]->index, open_[k]->index)) return false;
      }
    }
    return open_.size() > 1;
  }

  // Two columns of the same size all through, which no command can be: two sides.
  bool AreAlike() const {
    constexpr double kNarrow = 0.05;
    if (open_.size() != 2) return false;
    return std::ranges::all_of(open_, [&](const TableColumn* column) {
      const std::vector<double> numbers = NumbersOf(sheet_, column->index);
      const auto [low, high] = std::ranges::minmax(numbers);
      return numbers.size() > 1 && high - low < kNarrow * std::abs(high);
    });
  }

  const NamedUnit* UnitOf(const TableColumn& column) const {
    return UnitInHeading(HeadingOf(column), Quantity::kLength);
  }

  std::string HeadingOf(const TableColumn& column) const {
    return sheet_.headings.empty() ? "" : sheet_.headings[column.index].text;
  }

  void Give(TableColumn* column, Part part, const char* as) {
    column->part = part;
    const std::string heading = HeadingOf(*column);
    taken_.push_back(
        heading.empty() ? fmt::format("column {} is what was {}", column->index + 1, as)
                        : fmt::format("'{}' is what was {}", heading, as));
  }

  const Spreadsheet& sheet_;
  std::vector<TableColumn>& columns_;
  std::vector<std::string>& taken_;
  std::vector<TableColumn*> open_{};
};

}  // namespace

bool AreNumbers(const Spreadsheet& sheet, std::size_t column) {
  bool has_any = false;
  for (const CsvRecord& record : sheet.records) {
    std::string text = record[column].text;
    if (text.empty()) continue;
    if (text.starts_with('+')) text.erase(0, 1);
    if (!NumberOf(text, sheet.decimal)) return false;
    has_any = true;
  }
  return has_any;
}

std::vector<double> NumbersOf(const Spreadsheet& sheet, std::size_t column) {
  std::vector<double> numbers;
  for (const CsvRecord& record : sheet.records) {
    std::string text = record[column].text;
    if (text.starts_with('+')) text.erase(0, 1);
    if (const auto number = NumberOf(text, sheet.decimal)) numbers.push_back(*number);
  }
  return numbers;
}

void TakePartsByNumbers(const Spreadsheet& sheet,
                        std::vector<TableColumn>* columns,
                        std::vector<std::string>* taken) {
  PartsByNumbers(sheet, columns, taken).Take();
}

}  // namespace caltwin
