// How numbers are written into G-code.

#include <array>
#include <cmath>
#include <cstdlib>
#include <string>

#include <fmt/format.h>

#include "sim/base/require.h"
#include "sim/link/gcode.h"

namespace caltwin {
namespace {

// As GcodeNumber, for numbers whose last decimal is a whole number of a size that a
// double holds with room to spare: nearly all, and many times faster. False: not so.
bool AppendWhole(double value, int decimals, std::string* text) {
  constexpr std::array kScales = {1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6};
  constexpr double kMost = 1e12;
  if (decimals < 0 || static_cast<std::size_t>(decimals) >= kScales.size())
    return false;
  const double scaled = value * kScales[static_cast<std::size_t>(decimals)];
  if (!(std::abs(scaled) < kMost)) return false;
  long long whole = std::llabs(std::llround(scaled));
  int places = decimals;
  while (places > 0 && whole % 10 == 0) {
    whole /= 10;
    --places;
  }
  std::array<char, 24> digits{};
  std::size_t first = digits.size();
  const bool is_negative = scaled < 0 && whole != 0;
  const auto put_digit = [&] {
    digits[--first] = static_cast<char>('0' + whole % 10);
    whole /= 10;
  };
  for (int i = 0; i < places; ++i) put_digit();
  if (places > 0) digits[--first] = '.';
  do put_digit();
  while (whole > 0);
  if (is_negative) digits[--first] = '-';
  text->append(digits.data() + first, digits.size() - first);
  return true;
}

}  // namespace

std::string GcodeNumber(double value, int decimals) {
  Require(std::isfinite(value), "a number in G-code is finite");
  std::string text;
  if (AppendWhole(value, decimals, &text)) return text;
  text = fmt::format("{:.{}f}", value, decimals);
  if (text.find('.') != std::string::npos) {
    while (text.back() == '0') text.pop_back();
    if (text.back() == '.') text.pop_back();
  }
  return text == "-0" ? "0" : text;
}

std::string GcodeMove(std::string_view command,
                      const std::vector<std::pair<char, double>>& words_mm,
                      double feed_mm_s) {
  std::string line(command);
  for (const auto& [letter, value_mm] : words_mm) {
    line += ' ';
    line += letter;
    line += GcodeNumber(value_mm);
  }
  if (feed_mm_s > 0) line += " F" + GcodeNumber(FeedWord_mm_min(feed_mm_s));
  return line;
}

}  // namespace caltwin
