#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/base/input_error.h"
#include "sim/measure/csv.h"

namespace caltwin {

/// One line of a text and its words, split at blanks; lines count from 1.
struct TextLine {
  std::string_view text{};  ///< Without blanks at either end.
  int line = 0;
  CsvRecord words{};
};

/// Every line of a text that is not blank. `text` must outlive the lines.
std::vector<TextLine> LinesOf(std::string_view text);

/// A number written in full, with `decimal` as its mark; nullopt for anything else, not
/// finite numbers included.
std::optional<double> NumberOf(std::string_view text, char decimal = '.');

/// The number a field holds. Says so in `faults` where it holds none, and gives 0.
double NumberIn(const CsvField& field,
                const std::string& what,
                const std::string& name,
                Faults* faults);

/// What follows `key`, blanks left out, up to a blank, comma or `)`, as a number;
/// nullopt where the key does not stand there or no number follows.
std::optional<double> NumberAfter(std::string_view text, std::string_view key);

/// What ends before position `at`, blanks left out, as a number without a sign: "3500"
/// of "3500 mm/min"; nullopt where none does.
std::optional<double> NumberBefore(std::string_view text, std::size_t at);

/// Every number of a text, apart by anything else: "X:1.5, Y -2" has two.
std::vector<double> NumbersApart(std::string_view text);

/// In small letters.
std::string Lowered(std::string_view text);

/// In small letters, and without blanks, underscores and quotes: "Meas X" is "measx".
std::string PlainWord(std::string_view text);

/// Place of a field in a file.
Place PlaceOf(const CsvField& field, const std::string& name);

/// A date and time or a time of day as seconds, from any fixed zero:
/// `2021/06/13-20:05:00`, `2021-06-13 20:05:00.5`, `20:05:00` (then of the day).
/// Nullopt for anything else.
std::optional<double> ClockTime_s(std::string_view text);

/// The smallest step of which all values are multiples from the first, to a fiftieth of
/// it; 0 where there is none worth the name (fewer than three values, or all the same,
/// or coarser than an instrument's resolution may be).
double StepOf(const std::vector<double>& values_mm);

}  // namespace caltwin
