#include "sim/measure/import/console_line.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "sim/measure/import/fields.h"

namespace caltwin {
namespace {

constexpr double kHalfDay_s = 43200;

bool IsDigit(char c) {
  return c >= '0' && c <= '9';
}

void SkipBlanks(std::string_view* text) {
  text->remove_prefix(std::min(text->size(), text->find_first_not_of(" \t")));
}

// Blanks, brackets and dashes between a time and what was said.
void SkipMarks(std::string_view* text) {
  while (!text->empty()) {
    const char c = text->front();
    const bool is_dash = c == '-' && text->size() > 1 && (*text)[1] == ' ';
    if (c != ' ' && c != '\t' && c != ']' && c != ',' && c != '|' && !is_dash &&
        !(c == ':' && text->size() > 1 && (*text)[1] == ' ')) {
      return;
    }
    text->remove_prefix(1);
  }
}

// "9:36:22 PM", "19:32:04.295", "20:05:00,123" at the head of a text.
std::optional<double> TakeTimeOfDay(std::string_view* text) {
  std::size_t end = 0;
  int colons = 0;
  while (end < text->size() && (IsDigit((*text)[end]) || (*text)[end] == ':')) {
    colons += (*text)[end] == ':' ? 1 : 0;
    ++end;
  }
  if (colons == 3 && (*text)[end - 1] == ':') --end;  // "20:05:00: text"
  if (colons < 2 || end < 7) return std::nullopt;
  std::string clock((*text).substr(0, end));
  if (clock[1] == ':') clock.insert(0, "0");
  auto time_s = ClockTime_s(clock);
  if (!time_s) return std::nullopt;
  text->remove_prefix(end);
  if (text->size() > 1 && (text->front() == '.' || text->front() == ',') &&
      IsDigit((*text)[1])) {
    double digit_s = 0.1;
    text->remove_prefix(1);
    while (!text->empty() && IsDigit(text->front())) {
      *time_s += digit_s * (text->front() - '0');
      digit_s /= 10;
      text->remove_prefix(1);
    }
  }
  const std::string half = PlainWord(text->substr(0, 3));
  if (half.starts_with("pm") || half.starts_with("am")) {
    if (half[0] == 'p' && *time_s < kHalfDay_s) *time_s += kHalfDay_s;
    if (half[0] == 'a' && *time_s >= kHalfDay_s) *time_s -= kHalfDay_s;
    SkipBlanks(text);
    text->remove_prefix(2);
  }
  return time_s;
}

// A date before the time of day: digits, slashes, dashes and dots, then a blank or 'T'.
std::size_t LengthOfDate(std::string_view text) {
  std::size_t end = 0;
  int marks = 0;
  while (end < text.size() && (IsDigit(text[end]) || text[end] == '/' ||
                               text[end] == '-' || text[end] == '.')) {
    marks += IsDigit(text[end]) ? 0 : 1;
    ++end;
  }
  const bool is_date = marks == 2 && end >= 8 && end <= 10 && end + 1 < text.size();
  if (!is_date) return 0;
  if (text[end] == ',') ++end;
  return text[end] == ' ' || text[end] == 'T' || text[end] == '-' ? end + 1 : 0;
}

std::optional<double> TakeTime(std::string_view* text) {
  std::string_view rest = *text;
  if (rest.starts_with('[')) rest.remove_prefix(1);
  const std::size_t date = LengthOfDate(rest);
  std::string_view of_day = rest.substr(date);
  SkipBlanks(&of_day);
  auto time_s = TakeTimeOfDay(&of_day);
  if (!time_s) return std::nullopt;
  if (date > 0) {
    // Year first tells the day; other orders are only a time of day.
    const auto day_s = ClockTime_s(std::string(rest.substr(0, date - 1)) + " 00:00:00");
    if (day_s) *time_s += *day_s;
  }
  SkipMarks(&of_day);
  *text = of_day;
  return time_s;
}

// "g91g38.2z-30f250" as "g91 g38.2 z-30 f250": words of G-code that stand together.
std::string WithBlanks(const std::string& lower) {
  constexpr std::string_view kLetters = "gmtxyzfijkpqrsl";
  if (lower.size() < 4 || (lower[0] != 'g' && lower[0] != 'm')) return lower;
  std::string apart;
  std::size_t words = 0;
  for (std::size_t i = 0; i < lower.size(); ++i) {
    const char c = lower[i];
    const bool is_letter = kLetters.find(c) != std::string_view::npos;
    const bool is_number = IsDigit(c) || c == '.' || c == '-' || c == '+';
    const bool is_behind_number =
        i > 0 && (IsDigit(lower[i - 1]) || lower[i - 1] == '.');
    if ((!is_letter && !is_number) || (is_letter && i > 0 && !is_behind_number))
      return lower;
    if (is_letter && i > 0) apart += ' ';
    words += is_letter ? 1 : 0;
    apart += c;
  }
  return words > 1 ? apart : lower;
}

}  // namespace

namespace {

// "others < Bilinear Leveling Grid:", "tx > G28": who said it, and a mark.
bool TakeSpeaker(std::string_view* text) {
  constexpr std::size_t kLongest = 12;
  const std::size_t blank = text->find(' ');
  if (blank == 0 || blank > kLongest || blank + 2 >= text->size()) return false;
  const char mark = (*text)[blank + 1];
  const bool is_word = std::ranges::all_of(text->substr(0, blank), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
  });
  if (!is_word || (mark != '<' && mark != '>') || (*text)[blank + 2] != ' ')
    return false;
  text->remove_prefix(blank + 3);
  return true;
}

// What host, terminal or chat wrote before the line, and the time in it.
void TakePrefixes(ConsoleLine* line) {
  ConsoleLine& said = *line;
  constexpr std::array<std::string_view, 15> kPrefixes = {"recv:",
                                                          "read:",
                                                          "send:",
                                                          "sent:",
                                                          "received:",
                                                          "sending:",
                                                          "reply:",
                                                          ">>>",
                                                          "<<<",
                                                          "echo:",
                                                          "//",
                                                          "!!",
                                                          "$ ",
                                                          ">",
                                                          "<"};
  for (bool is_done = false; !is_done;) {
    is_done = true;
    SkipBlanks(&said.text);
    if (said.text.starts_with("- ") || said.text.starts_with("* ")) {
      said.text.remove_prefix(2);
      is_done = false;
      continue;
    }
    const auto t_s = TakeTime(&said.text);
    if (t_s) said.t_s = *t_s;
    if (t_s || TakeSpeaker(&said.text)) {
      is_done = false;
      continue;
    }
    const std::string head = Lowered(said.text.substr(0, 10));
    for (const std::string_view prefix : kPrefixes) {
      if (!head.starts_with(prefix)) continue;
      said.text.remove_prefix(prefix.size());
      is_done = false;
      break;
    }
  }
}

}  // namespace

ConsoleLine ConsoleLineOf(std::string_view line) {
  ConsoleLine said{.text = line};
  TakePrefixes(&said);
  // "N12 G29*33": a line number.
  if (said.text.size() > 1 && (said.text.front() == 'N' || said.text.front() == 'n') &&
      IsDigit(said.text[1])) {
    const std::size_t blank = said.text.find(' ');
    if (blank != std::string_view::npos) said.text.remove_prefix(blank + 1);
  }
  const std::size_t star = said.text.find('*');
  if (star != std::string_view::npos && star + 1 < said.text.size() &&
      said.text.find_first_not_of("0123456789", star + 1) == std::string_view::npos) {
    said.text = said.text.substr(0, star);
  }
  said.lower = WithBlanks(Lowered(said.text));
  return said;
}

bool IsCommand(const ConsoleLine& line, std::string_view word) {
  if (!line.lower.starts_with(word)) return false;
  if (line.lower.size() == word.size()) return true;
  const char next = line.lower[word.size()];
  return next == ' ' || next == '*' || next == '\t' || next == ';';
}

std::optional<double> WordOf(const ConsoleLine& line, char letter) {
  const std::string words = line.lower.substr(0, line.lower.find(';'));
  for (std::size_t at = words.find(' '); at != std::string::npos;
       at = words.find(' ', at + 1)) {
    if (at + 2 > words.size() - 1 || words[at + 1] != letter) continue;
    const std::string rest = words.substr(at + 2);
    const auto value = NumberOf(rest.substr(0, rest.find_first_of(" \t*")));
    if (value) return value;
  }
  return std::nullopt;
}

std::optional<double> GrblSetting(const ConsoleLine& line, int number) {
  std::string_view rest = line.lower;
  const std::string key = fmt::format("${}", number);
  if (!rest.starts_with(key)) return std::nullopt;
  rest.remove_prefix(key.size());
  const std::size_t at = rest.find_first_not_of(" =:\t");
  if (at == std::string_view::npos || at == 0) return std::nullopt;
  rest.remove_prefix(at);
  return NumberOf(rest.substr(0, rest.find_first_not_of(".0123456789")));
}

}  // namespace caltwin
