#include "sim/measure/import/table_notes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "sim/measure/import/table_columns.h"

namespace caltwin {
namespace {

/// Columns a, b and c with c = a - b in every line, or b - a.
struct Difference {
  std::size_t a = 0, b = 0, c = 0;
};

// Whether c is a - b, up to a tenth of how much c changes.
bool IsDifference(const Spreadsheet& sheet, const Difference& columns) {
  constexpr double kAlike = 0.1;
  const std::vector<double> a = NumbersOf(sheet, columns.a),
                            b = NumbersOf(sheet, columns.b),
                            c = NumbersOf(sheet, columns.c);
  if (a.size() != b.size() || a.size() != c.size()) return false;
  double left = 0, size = 0, mean = 0;
  for (const double each : c) mean += each / static_cast<double>(c.size());
  for (std::size_t i = 0; i < c.size(); ++i) {
    left += std::pow(c[i] - (a[i] - b[i]), 2);
    size += std::pow(c[i] - mean, 2);
  }
  return size > 0 && left <= kAlike * kAlike * size;
}

bool IsWorkOffset(const std::string& heading) {
  constexpr std::array<std::string_view, 9> kWords = {
      "g54", "g55", "g56", "g57", "g58", "g59", "wco", "offset", "g92"};
  const std::vector<std::string> tokens = TokensOf(heading);
  return std::ranges::any_of(tokens, [&](const std::string& token) {
    return std::ranges::find(kWords, token) != kWords.end();
  });
}

// Before and after: their difference is what was done, and no error.
bool IsBeforeAndAfter(const std::string& one, const std::string& other) {
  constexpr std::array<std::string_view, 8> kWords = {
      "before", "after", "avant", "apr", "vorher", "nachher", "start", "end"};
  const auto has = [&](const std::string& heading) {
    const std::vector<std::string> tokens = TokensOf(heading);
    return std::ranges::any_of(tokens, [&](const std::string& token) {
      return std::ranges::find(kWords, token) != kWords.end();
    });
  };
  return has(one) && has(other);
}

// Steps sent up and steps sent down that differ by more each time.
void AddStepsApart(const Spreadsheet& sheet, Imported* imported) {
  constexpr std::size_t kFewest = 4;
  const auto named = [&](std::string_view one, std::string_view other) {
    for (std::size_t i = 0; i < sheet.headings.size(); ++i) {
      const std::vector<std::string> tokens = TokensOf(sheet.headings[i].text);
      const auto has = [&](std::string_view word) {
        return std::ranges::find(tokens, word) != tokens.end();
      };
      const bool are_steps = has("steps") || has("pulses") || has("counts");
      if (are_steps && (has(one) || has(other))) return i;
    }
    return sheet.headings.size();
  };
  const std::size_t up = named("up", "forward"), down = named("down", "back");
  if (up == sheet.headings.size() || down == sheet.headings.size()) return;
  const std::vector<double> ups = NumbersOf(sheet, up), downs = NumbersOf(sheet, down);
  if (ups.size() < kFewest || ups.size() != downs.size()) return;
  for (std::size_t i = 1; i < ups.size(); ++i) {
    const double more = downs[i] - ups[i], before = downs[i - 1] - ups[i - 1];
    if (more == 0 || more * before < 0 || std::abs(more) <= std::abs(before)) return;
  }
  const double apart = downs.back() - ups.back();
  imported->notes.push_back(
      {.kind = FileNote::Kind::kElsewhere,
       .what = "firmware",
       .sentence = fmt::format(
           "The controller itself sends {:g} steps {} '{}' than '{}' in all, more with "
           "every move: what the axis drifts by is counted wrongly (a rounding of "
           "steps/mm that are no whole number), and no screw or motor loses it. Choose "
           "steps/mm that make whole steps, or another version of the firmware",
           std::abs(apart),
           apart > 0 ? "more" : "fewer",
           sheet.headings[down].text,
           sheet.headings[up].text)});
}

// Small against what is measured, as an error of an artefact is.
bool IsSmall(const Spreadsheet& sheet, const Difference& columns) {
  constexpr double kSmall = 0.2;
  double apart = 0;
  for (const double b : NumbersOf(sheet, columns.b))
    apart = std::max(apart, std::abs(b));
  const auto [least, most] = std::ranges::minmax(NumbersOf(sheet, columns.c));
  return most - least < kSmall * apart;
}

// What it means that c = a - b in every line; nothing: no reason that people know.
std::optional<FileNote> NoteOn(const Spreadsheet& sheet, const Difference& columns) {
  const std::string& a = sheet.headings[columns.a].text;
  const std::string& b = sheet.headings[columns.b].text;
  const std::string& c = sheet.headings[columns.c].text;
  FileNote note{.kind = FileNote::Kind::kElsewhere};
  if (IsWorkOffset(c)) {
    note.what = "work_offset";
    note.sentence = fmt::format(
        "'{}' and '{}' differ by '{}' in every line, whatever else changes: one of the "
        "two was taken in work coordinates and the other in machine coordinates. The "
        "machine does what it is told; correct the routine, or measure with that "
        "offset "
        "at 0",
        a,
        b,
        c);
    return note;
  }
  if (!IsSmall(sheet, columns)) return std::nullopt;
  note.what = "gauge";
  note.sentence = fmt::format(
      "'{}' is '{}' less '{}' in every line: what is believed of the block or plate is "
      "wrong, and the machine does what it is told. Enter the measured size",
      c,
      a,
      b);
  return note;
}

std::vector<Difference> AllDifferences(const Spreadsheet& sheet,
                                       const std::vector<std::size_t>& numbers) {
  std::vector<Difference> all;
  for (const std::size_t a : numbers) {
    for (const std::size_t b : numbers) {
      for (const std::size_t c : numbers) {
        if (a != b && b != c && a != c) all.push_back({a, b, c});
      }
    }
  }
  std::erase_if(all, [&](const Difference& columns) {
    return IsBeforeAndAfter(sheet.headings[columns.a].text,
                            sheet.headings[columns.b].text) ||
           !IsDifference(sheet, columns);
  });
  return all;
}

}  // namespace

void AddDifferences(const Spreadsheet& sheet, Imported* imported) {
  constexpr std::size_t kFewest = 4, kMostColumns = 12;
  if (imported->notes.empty()) AddStepsApart(sheet, imported);
  std::vector<std::size_t> numbers;
  for (std::size_t i = 0; i < sheet.headings.size(); ++i) {
    const bool is_whole = NumbersOf(sheet, i).size() == sheet.records.size();
    if (is_whole && AreNumbers(sheet, i)) numbers.push_back(i);
  }
  if (numbers.size() < 3 || numbers.size() > kMostColumns ||
      sheet.records.size() < kFewest || !imported->notes.empty()) {
    return;
  }
  for (const Difference& columns : AllDifferences(sheet, numbers)) {
    std::optional<FileNote> note = NoteOn(sheet, columns);
    if (!note) continue;
    imported->notes.push_back(std::move(*note));
    return;
  }
}

}  // namespace caltwin
