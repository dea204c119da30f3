#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "sim/measure/import/fields.h"
#include "sim/measure/import/told_stories.h"

namespace caltwin {
namespace {

/// "Y2 moves 99.5 cm".
struct Side {
  char axis = 0;
  std::string name{};  ///< As written.
  double moved = 0;    ///< In the unit of the other side.
  std::string unit{};
};

// "y1", "ya", "y_left", "left y": an axis and which of its sides; nullopt: no such.
std::optional<char> AxisOfSide(const std::string& word, const std::string& next) {
  constexpr std::string_view kAxes = "xyz", kSides = "12ablr";
  const auto is_axis = [&](char c) {
    return kAxes.find(c) != std::string_view::npos;
  };
  const auto is_side = [](const std::string& name) {
    return name == "left" || name == "right" || name == "front" || name == "rear" ||
           name == "back";
  };
  if (word.empty()) return std::nullopt;
  if (word.size() == 2 && is_axis(word[0]) &&
      kSides.find(word[1]) != std::string_view::npos) {
    return word[0];
  }
  const bool is_joint = word.size() > 2 && is_axis(word[0]) &&
                        (word[1] == '_' || word[1] == '-') && is_side(word.substr(2));
  if (is_joint) return word[0];
  if (word.size() == 1 && is_axis(word[0]) && is_side(next)) return word[0];
  const bool is_behind = next.size() == 1 && is_axis(next[0]) && is_side(word);
  return is_behind ? std::optional(next[0]) : std::nullopt;
}

std::optional<Side> SideIn(const TextLine& line) {
  std::vector<std::string> words;
  for (const CsvField& word : line.words) {
    std::string lower = Lowered(word.text);
    while (!lower.empty() && (lower.back() == ':' || lower.back() == ','))
      lower.pop_back();
    words.push_back(lower);
  }
  if (words.size() < 3) return std::nullopt;
  const auto axis = AxisOfSide(words[0], words[1]);
  if (!axis) return std::nullopt;
  for (std::size_t i = 1; i + 1 < words.size(); ++i) {
    const bool is_moved = words[i] == "moves" || words[i] == "moved" ||
                          words[i] == "travels" || words[i] == "travelled" ||
                          words[i] == "went" || words[i] == "goes";
    if (!is_moved) continue;
    std::string number = words[i + 1];
    std::string unit = i + 2 < words.size() ? words[i + 2] : "";
    const std::size_t end = number.find_first_not_of(".0123456789");
    if (end != std::string::npos) {
      unit = number.substr(end);
      number.erase(end);
    }
    const auto moved = NumberOf(number);
    if (!moved || *moved <= 0) return std::nullopt;
    const bool is_two = words[0].size() == 1 || words[1].size() == 1;
    const std::string name =
        line.words[0].text + (is_two ? " " + line.words[1].text : "");
    return Side{*axis, name, *moved, unit};
  }
  return std::nullopt;
}

}  // namespace

std::optional<Imported> TwoSidesIn(const std::string& text) {
  constexpr double kAlike = 1e-3, kMost = 0.2;
  // Both may stand in one line.
  std::string lines = text;
  for (const std::string_view between : {", ", "; ", " and ", " but "}) {
    for (std::size_t at = lines.find(between); at != std::string::npos;
         at = lines.find(between, at + 1)) {
      lines.replace(at, between.size(), "\n");
    }
  }
  std::vector<Side> sides;
  for (const TextLine& line : LinesOf(lines)) {
    if (auto side = SideIn(line)) sides.push_back(std::move(*side));
  }
  if (sides.size() != 2 || sides[0].axis != sides[1].axis ||
      sides[0].unit != sides[1].unit || sides[0].name == sides[1].name) {
    return std::nullopt;
  }
  const double factor = sides[1].moved / sides[0].moved;
  if (std::abs(factor - 1) < kAlike || std::abs(factor - 1) > kMost)
    return std::nullopt;
  const Side& shorter = sides[factor < 1 ? 1 : 0];
  const Side& longer = sides[factor < 1 ? 0 : 1];
  Imported imported =
      ToldOf("what two motors of one axis moved",
             "why the sides differ: one way of one length does not tell a pulley "
             "or belt from slip or lost steps",
             "tape",
             "measure both sides at a quarter, half and the "
             "whole way, there and back: a wrong pulley errs by "
             "the same share on every way, slip and lost steps "
             "do not");
  imported.notes.push_back(
      {.kind = FileNote::Kind::kFact,
       .sentence = fmt::format(
           "Side {} goes {:.2g} % less far than {} on the same move ({:g} to {:g} "
           "{}): the gantry racks by the difference. Steps/mm that differ from side to "
           "side are no cure, they hide it. Pulleys of other teeth or a belt of "
           "another "
           "pitch err by the same share on every way; a loose pulley, a slipping belt "
           "or lost steps err by more on some moves than on others; a driver's "
           "switches "
           "would be off by a factor of two",
           shorter.name,
           100 * (1 - shorter.moved / longer.moved),
           longer.name,
           shorter.moved,
           longer.moved,
           longer.unit),
       .fact = "scale",
       .axis = std::string(1, sides[0].axis),
       .word = "sides",
       .figures = {{"factor", factor}}});
  return imported;
}

}  // namespace caltwin
