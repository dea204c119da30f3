#include "sim/measure/import/fields.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <chrono>
#include <cmath>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/measure/instrument.h"

namespace caltwin {
namespace {

constexpr std::string_view kBlanks = " \t\r\f\v";

CsvRecord WordsOf(std::string_view line, int number) {
  CsvRecord words;
  std::size_t at = 0;
  while ((at = line.find_first_not_of(kBlanks, at)) != std::string_view::npos) {
    const std::size_t end = std::min(line.size(), line.find_first_of(kBlanks, at));
    words.push_back({.text = std::string(line.substr(at, end - at)),
                     .line = number,
                     .column = static_cast<int>(at) + 1});
    at = end;
  }
  return words;
}

std::string_view Trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

/// Takes a whole number off the front of the text.
std::optional<int> TakeInteger(std::string_view* text) {
  int value = 0;
  const auto [end, error] =
      std::from_chars(text->data(), text->data() + text->size(), value);
  if (error != std::errc() || text->starts_with('-')) return std::nullopt;
  text->remove_prefix(static_cast<std::size_t>(end - text->data()));
  return value;
}

bool TakeOneOf(std::string_view marks, std::string_view* text) {
  if (text->empty() || marks.find(text->front()) == std::string_view::npos) {
    return false;
  }
  text->remove_prefix(1);
  return true;
}

std::optional<double> TimeOfDay_s(std::string_view text) {
  const auto hours = TakeInteger(&text);
  if (!hours || *hours > 24 || !TakeOneOf(":", &text)) return std::nullopt;
  const auto minutes = TakeInteger(&text);
  if (!minutes || *minutes > 59) return std::nullopt;
  double seconds = 0;
  if (TakeOneOf(":", &text)) {
    const auto value = NumberOf(text);
    if (!value || *value < 0 || *value >= 61) return std::nullopt;
    seconds = *value;
  } else if (!text.empty()) {
    return std::nullopt;
  }
  return SFromH(static_cast<double>(*hours)) + SFromMin(static_cast<double>(*minutes)) +
         seconds;
}

}  // namespace

std::vector<TextLine> LinesOf(std::string_view text) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  std::vector<TextLine> lines;
  for (int number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.size(), text.find('\n'));
    const std::string_view line = text.substr(0, end);
    if (!Trimmed(line).empty()) {
      lines.push_back(
          {.text = Trimmed(line), .line = number, .words = WordsOf(line, number)});
    }
    text.remove_prefix(std::min(text.size(), end + 1));
  }
  return lines;
}

std::optional<double> NumberOf(std::string_view text, char decimal) {
  std::string plain(text);
  if (decimal != '.') {
    if (plain.find('.') != std::string::npos) return std::nullopt;
    std::ranges::replace(plain, decimal, '.');
  }
  std::string_view digits = plain;
  if (digits.starts_with('+') && !digits.starts_with("+-")) digits.remove_prefix(1);
  double value = 0;
  const auto [end, error] =
      std::from_chars(digits.data(), digits.data() + digits.size(), value);
  const bool is_whole = error == std::errc() && end == digits.data() + digits.size();
  if (!is_whole || !std::isfinite(value)) return std::nullopt;
  return value;
}

double NumberIn(const CsvField& field,
                const std::string& what,
                const std::string& name,
                Faults* faults) {
  const auto value = NumberOf(field.text);
  if (!value) {
    faults->Add(PlaceOf(field, name),
                fmt::format("{} = '{}' is not a finite number", what, field.text),
                field.text.find(',') != std::string::npos
                    ? "this format has a dot as its decimal mark"
                    : "");
  }
  return value.value_or(0);
}

std::optional<double> NumberAfter(std::string_view text, std::string_view key) {
  const std::size_t at = text.find(key);
  if (at == std::string_view::npos) return std::nullopt;
  std::string_view rest = text.substr(at + key.size());
  rest.remove_prefix(std::min(rest.size(), rest.find_first_not_of(' ')));
  return NumberOf(rest.substr(0, rest.find_first_of(" ,)\t#")));
}

std::optional<double> NumberBefore(std::string_view text, std::size_t at) {
  const std::size_t last = text.substr(0, at).find_last_not_of(' ');
  if (last == std::string_view::npos) return std::nullopt;
  const std::string_view before = text.substr(0, last + 1);
  return NumberOf(before.substr(before.find_last_not_of(".0123456789") + 1));
}

std::string Lowered(std::string_view text) {
  std::string lower(text);
  std::ranges::transform(lower, lower.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  return lower;
}

std::string PlainWord(std::string_view text) {
  std::string word;
  for (const char c : text) {
    if (kBlanks.find(c) != std::string_view::npos || c == '_' || c == '"') continue;
    word += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return word;
}

Place PlaceOf(const CsvField& field, const std::string& name) {
  return {.file = name, .line = field.line, .column = field.column};
}

std::optional<double> ClockTime_s(std::string_view text) {
  if (text.size() < 8 || (text[4] != '/' && text[4] != '-')) return TimeOfDay_s(text);
  const auto year = TakeInteger(&text);
  if (!year || *year > 9999 || !TakeOneOf("/-", &text)) return std::nullopt;
  const auto month = TakeInteger(&text);
  if (!month || !TakeOneOf("/-", &text)) return std::nullopt;
  const auto day = TakeInteger(&text);
  if (!day || *month > 12 || *day > 31 || !TakeOneOf("-T ", &text)) return std::nullopt;
  const std::chrono::year_month_day date(
      std::chrono::year(*year),
      std::chrono::month(static_cast<unsigned>(*month)),
      std::chrono::day(static_cast<unsigned>(*day)));
  if (!date.ok()) return std::nullopt;
  const auto days = std::chrono::sys_days(date).time_since_epoch().count();
  const auto of_day_s = TimeOfDay_s(text);
  if (!of_day_s) return std::nullopt;
  return SFromH(24.0 * static_cast<double>(days)) + *of_day_s;
}

double StepOf(const std::vector<double>& values_mm) {
  constexpr double kOfAStep = 0.02;
  std::vector<double> sorted = values_mm;
  std::ranges::sort(sorted);
  double step = 0;
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    const double gap = sorted[i] - sorted[i - 1];
    const bool is_rounding = gap <= 1e-9 * std::abs(sorted[i]) + 1e-12;
    if (!is_rounding && (step == 0 || gap < step)) step = gap;
  }
  if (step == 0 || values_mm.size() < 3) return 0;
  // Coarser than any instrument.
  if (!Instrument::kResolution_um.Contains(UmFromMm(step))) return 0;
  const bool is_grid = std::ranges::all_of(sorted, [&](double value) {
    const double steps = (value - sorted.front()) / step;
    return std::abs(steps - std::round(steps)) < kOfAStep;
  });
  return is_grid ? step : 0;
}

std::vector<double> NumbersApart(std::string_view text) {
  std::vector<double> numbers;
  constexpr std::string_view kOfNumber = "+-.0123456789";
  for (std::size_t at = text.find_first_of(kOfNumber); at != std::string_view::npos;) {
    const std::size_t end =
        std::min(text.size(), text.find_first_not_of(kOfNumber, at));
    std::string word(text.substr(at, end - at));
    if (word.starts_with('+')) word.erase(0, 1);
    if (const auto number = NumberOf(word)) numbers.push_back(*number);
    at = text.find_first_of(kOfNumber, end);
  }
  return numbers;
}

}  // namespace caltwin
