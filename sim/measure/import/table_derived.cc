#include "sim/measure/import/table_derived.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "sim/measure/data_header.h"
#include "sim/measure/import/fields.h"
#include "sim/measure/import/table_columns.h"

namespace caltwin {
namespace {

// "A - 74": the column that is lessened, and by how much.
struct Derived {
  std::size_t from = 0;
  double less = 0;
};

std::optional<Derived> DerivedIn(const Spreadsheet& sheet, std::size_t column) {
  const std::string& heading = sheet.headings[column].text;
  const std::size_t minus = heading.rfind('-');
  if (minus == std::string::npos || minus == 0) return std::nullopt;
  const auto less = NumberOf(PlainWord(heading.substr(minus + 1)), sheet.decimal);
  const std::string name = PlainWord(heading.substr(0, minus));
  if (!less || name.empty()) return std::nullopt;
  for (std::size_t i = 0; i < sheet.headings.size(); ++i) {
    if (i != column && PlainWord(sheet.headings[i].text) == name)
      return Derived{i, *less};
  }
  return std::nullopt;
}

// Whether each line of the column is what its heading says.
bool IsReckoned(const Spreadsheet& sheet, std::size_t column, const Derived& derived) {
  constexpr double kRounding = 0.02;
  return std::ranges::all_of(sheet.records, [&](const CsvRecord& record) {
    const auto value = NumberOf(record[column].text, sheet.decimal);
    const auto from = NumberOf(record[derived.from].text, sheet.decimal);
    return value && from && std::abs(*from - derived.less - *value) < kRounding;
  });
}

void Erase(Spreadsheet* sheet, std::size_t column) {
  const auto at = static_cast<std::ptrdiff_t>(column);
  sheet->headings.erase(sheet->headings.begin() + at);
  for (CsvRecord& record : sheet->records) record.erase(record.begin() + at);
}

// Whether a heading sets one sense against the other.
bool SetsSensesApart(const std::string& heading) {
  constexpr std::array<std::array<std::string_view, 2>, 7> kPairs = {{
      {"even", "odd"},
      {"forward", "backward"},
      {"forward", "back"},
      {"forth", "back"},
      {"there", "back"},
      {"out", "in"},
      {"rightward", "leftward"},
  }};
  constexpr std::array<std::string_view, 5> kAgainst = {
      "vs", "versus", "against", "minus", "less"};
  const std::vector<std::string> tokens = TokensOf(heading);
  const auto has = [&](std::string_view word) {
    return std::ranges::find(tokens, word) != tokens.end();
  };
  return std::ranges::any_of(kAgainst, has) &&
         std::ranges::any_of(
             kPairs, [&](const auto& pair) { return has(pair[0]) && has(pair[1]); });
}

}  // namespace

std::string DropDerived(Spreadsheet* sheet) {
  if (sheet->headings.empty() || sheet->records.empty()) return "";
  std::set<double> nominals;
  std::string dropped;
  for (std::size_t i = sheet->headings.size(); i-- > 0;) {
    const auto derived = DerivedIn(*sheet, i);
    if (!derived || !IsReckoned(*sheet, i, *derived)) continue;
    nominals.insert(derived->less);
    dropped = fmt::format(
        "'{}'{}{}", sheet->headings[i].text, dropped.empty() ? "" : ", ", dropped);
    Erase(sheet, i);
  }
  if (nominals.size() != 1) return "";
  CsvField heading = sheet->headings.front();
  heading.text = "nominal";
  sheet->headings.insert(sheet->headings.begin(), heading);
  for (CsvRecord& record : sheet->records) {
    CsvField nominal = record.front();
    nominal.text = fmt::format("{}", *nominals.begin());
    std::ranges::replace(nominal.text, '.', sheet->decimal);
    record.insert(record.begin(), nominal);
  }
  return fmt::format(
      "{} are reckoned: each part should measure {:g}", dropped, *nominals.begin());
}

std::string PartSenses(Spreadsheet* sheet) {
  if (sheet->headings.empty()) return "";
  // Beside both senses themselves it is reckoned.
  const bool has_senses =
      std::ranges::any_of(sheet->headings, [](const CsvField& heading) {
        constexpr std::array<std::string_view, 4> kOne = {
            "forward", "backward", "even", "odd"};
        const std::vector<std::string> tokens = TokensOf(heading.text);
        return !SetsSensesApart(heading.text) &&
               std::ranges::any_of(kOne, [&](std::string_view word) {
                 return std::ranges::find(tokens, word) != tokens.end();
               });
      });
  if (has_senses) return "";
  for (std::size_t i = 0; i < sheet->headings.size(); ++i) {
    if (!SetsSensesApart(sheet->headings[i].text) || !AreNumbers(*sheet, i)) continue;
    double sum = 0;
    for (const double number : NumbersOf(*sheet, i)) sum += number;
    CsvField heading = sheet->headings[i];
    heading.text = "sense";
    sheet->headings.push_back(heading);
    std::vector<CsvRecord> both;
    for (CsvRecord& record : sheet->records) {
      CsvField sense = record[i];
      sense.text = sum > 0 ? "-" : "+";
      CsvRecord other = record;
      record.push_back(sense);
      sense.text = sum > 0 ? "+" : "-";
      other[i].text = "0";
      other.push_back(sense);
      both.push_back(std::move(record));
      both.push_back(std::move(other));
    }
    sheet->records = std::move(both);
    return fmt::format(
        "'{}' is how far one sense lies from the other, which is read as 0: which of "
        "them is + nobody says, and the mean is taken as lost motion",
        sheet->headings[i].text);
  }
  return "";
}

double CountedStep_mm(const std::string& text) {
  double steps_per_mm = 0;
  bool is_counted = false;
  for (const TextLine& line : LinesOf(text)) {
    const std::string lower = Lowered(line.text);
    const std::size_t in_steps = lower.find("in steps");
    // "in steps of 10 mm" says how far apart targets are.
    is_counted |= in_steps != std::string::npos &&
                  lower.compare(in_steps, 12, "in steps of ") != 0;
    const std::size_t at = lower.find("steps/mm");
    if (at == std::string::npos) continue;
    const auto steps = NumberBefore(lower, at);
    if (steps && SettingsInForce::kSteps_per_mm.Contains(*steps)) steps_per_mm = *steps;
  }
  return is_counted && steps_per_mm > 0 ? 1 / steps_per_mm : 0;
}

}  // namespace caltwin
