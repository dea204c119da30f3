#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/measure/import/fields.h"
#include "sim/measure/import/told_stories.h"

namespace caltwin {
namespace {

/// Lines of two numbers one below the other, and the axis that the line before names.
struct Block {
  char axis = 0;
  std::vector<std::pair<double, double>> told_read_mm{};
};

// The only axis that stands by itself in the words; 0: none, or several.
char AxisIn(const std::vector<std::string>& words) {
  char axis = 0;
  for (const std::string& word : words) {
    const bool is_axis = word == "x" || word == "y" || word == "z";
    if (is_axis && axis != 0 && axis != word[0]) return 0;
    if (is_axis) axis = word[0];
  }
  return axis;
}

std::vector<Block> BlocksIn(const std::string& text) {
  std::vector<Block> blocks;
  char axis = 0;
  bool is_on = false;
  int last = 0;
  for (const TextLine& line : LinesOf(text)) {
    const auto told =
        line.words.size() == 2 ? NumberOf(line.words[0].text) : std::nullopt;
    const auto read = told ? NumberOf(line.words[1].text) : std::nullopt;
    if (!read) {
      std::vector<std::string> words;
      for (const CsvField& word : line.words) words.push_back(PlainWord(word.text));
      const char named = AxisIn(words);
      // A blank line ends what the line above it named.
      axis = named != 0 ? named : line.line == last + 1 ? axis : char(0);
      is_on = false;
    } else {
      if (!is_on) blocks.push_back({.axis = axis});
      is_on = true;
      blocks.back().told_read_mm.emplace_back(*told, *read);
    }
    last = line.line;
  }
  return blocks;
}

/// What is added, in full from this height on.
struct Faded {
  double constant_mm = 0, height_mm = 0;
};

// d = c h / H below H, c from there on; two readings of each at least, and 0 no part
// of either.
std::optional<Faded> FadedIn(const Block& block) {
  constexpr double kLeast_mm = 0.3, kAlike = 0.05, kSame_mm = 0.03;
  auto readings = block.told_read_mm;
  std::ranges::sort(readings);
  if (readings.size() < 4 || readings.front().first <= 0) return std::nullopt;
  const double constant_mm = readings.back().second - readings.back().first;
  if (std::abs(constant_mm) < kLeast_mm) return std::nullopt;
  const double slope =
      (readings.front().second - readings.front().first) / readings.front().first;
  const double height_mm = constant_mm / slope;
  if (!(height_mm > 0)) return std::nullopt;
  std::size_t num_below = 0, num_above = 0;
  for (const auto& [told_mm, read_mm] : readings) {
    const double share = std::min(1.0, told_mm / height_mm);
    const double off_mm = read_mm - told_mm - share * constant_mm;
    if (std::abs(off_mm) > std::max(kSame_mm, kAlike * share * std::abs(constant_mm)))
      return std::nullopt;
    const bool is_at_most = told_mm <= (1 + kAlike) * height_mm;
    num_below += is_at_most && share < 1 - kAlike ? 1 : 0;
    num_above += share > 1 - kAlike ? 1 : 0;
  }
  if (num_below < 2 || num_above < 2) return std::nullopt;
  return Faded{constant_mm, height_mm};
}

// "probe z offset -2.3": an offset of that size stands in the text.
std::string OffsetLike(const std::string& text, double constant_mm) {
  constexpr double kAlike = 0.1;
  for (const TextLine& line : LinesOf(text)) {
    const std::string lower = Lowered(line.text);
    const std::size_t at = lower.find("offset");
    if (at == std::string::npos) continue;
    for (const double mm : NumbersApart(std::string_view(lower).substr(at))) {
      if (std::abs(std::abs(mm) / std::abs(constant_mm) - 1) < kAlike)
        return fmt::format(
            "It is as large as the offset of {:g} mm at line {}. ", mm, line.line);
    }
  }
  return "";
}

}  // namespace

std::optional<Imported> FadedConstantIn(const std::string& text) {
  const std::vector<Block> blocks = BlocksIn(text);
  for (const Block& block : blocks) {
    const auto faded = FadedIn(block);
    if (!faded || (block.axis != 'z' && block.axis != 0)) continue;
    std::size_t num_right = 0, num_too = 0;
    for (const Block& other : blocks) {
      for (const auto& [told_mm, read_mm] : other.told_read_mm) {
        const double off_mm = read_mm - told_mm;
        num_right += std::abs(off_mm) < 1e-3 * told_mm ? 1 : 0;
        const bool is_same = std::abs(off_mm / faded->constant_mm - 1) < 0.05;
        num_too += &other != &block && is_same ? 1 : 0;
      }
    }
    Imported imported{.recognised = {"moves of Z, too long by a constant that fades "
                                     "in"}};
    imported.notes.push_back(
        {.kind = FileNote::Kind::kElsewhere,
         .what = "settings",
         .sentence = fmt::format(
             "Z is {:+.2f} mm off at every height above {:.3g} mm, and by a share "
             "below "
             "it ({:.3g} mm a millimetre): a constant that comes in bit by bit, and no "
             "scale{}{}. A correction of the bed by as much that fades over {:.3g} mm "
             "does that: the heights of the mesh are not near 0. {}Steps/mm, screw and "
             "slicer are not in question; do not turn at the steps. Look at the mesh, "
             "set the probe's Z offset, probe again; a fade height of 0 as a test "
             "makes "
             "the moves right",
             faded->constant_mm,
             faded->height_mm,
             1 + faded->constant_mm / faded->height_mm,
             num_too > 0 ? fmt::format(", in {} other sizes too", num_too) : "",
             num_right > 0 ? fmt::format("; {} other moves are right", num_right) : "",
             faded->height_mm,
             OffsetLike(text, faded->constant_mm)),
         .fact = "constant",
         .axis = "z",
         .word = "fade",
         .figures = {{"change_um", UmFromMm(faded->constant_mm)},
                     {"fade_um", UmFromMm(faded->height_mm)}}});
    return imported;
  }
  return std::nullopt;
}

}  // namespace caltwin
