#include "sim/measure/import/drawn_path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/measure/import/console_line.h"
#include "sim/measure/import/fields.h"
#include "sim/measure/import/table_columns.h"
#include "sim/measure/import/text_table.h"

namespace caltwin {
namespace {

/// How far cutting moves of G-code reach along x and y [mm].
struct Extent2 {
  std::array<double, 2> least_mm{HUGE_VAL, HUGE_VAL};
  std::array<double, 2> most_mm{-HUGE_VAL, -HUGE_VAL};
  int moves = 0;

  double Size_mm(std::size_t k) const { return most_mm[k] - least_mm[k]; }
};

Extent2 ExtentOf(const std::string& text) {
  Extent2 extent;
  for (const TextLine& line : LinesOf(text)) {
    const ConsoleLine said = ConsoleLineOf(line.text);
    bool is_move = false;
    for (const char* word : {"g1", "g2", "g3", "g01", "g02", "g03"}) {
      is_move |= IsCommand(said, word);
    }
    if (!is_move) continue;
    ++extent.moves;
    for (std::size_t k = 0; k < 2; ++k) {
      const auto to_mm = WordOf(said, "xy"[k]);
      if (!to_mm) continue;
      extent.least_mm[k] = std::min(extent.least_mm[k], *to_mm);
      extent.most_mm[k] = std::max(extent.most_mm[k], *to_mm);
    }
  }
  return extent;
}

// "tool 3.175mm", "bit: 1/8" is not read; kUnknown.
double ToolIn_mm(const std::string& lower) {
  for (const std::string_view word : {"tool", "cutter", "bit", "end mill", "endmill"}) {
    for (std::size_t at = lower.find(word); at != std::string::npos;
         at = lower.find(word, at + 1)) {
      constexpr std::size_t kNear = 24;
      const std::string near =
          lower.substr(at, std::min(kNear, lower.find('\n', at) - at));
      const std::size_t unit = near.find("mm");
      const auto mm =
          unit == std::string::npos ? std::nullopt : NumberBefore(near, unit);
      if (mm && *mm > 0) return *mm;
    }
  }
  return kUnknown;
}

// "10mm x 10mm", "40 x 30 mm"; kUnknown each.
std::array<double, 2> DrawnIn_mm(const std::string& lower) {
  for (const TextLine& line : LinesOf(lower)) {
    const std::string text(line.text);
    for (std::size_t at = text.find(" x "); at != std::string::npos;
         at = text.find(" x ", at + 1)) {
      const std::size_t first_end =
          text.compare(at - std::min<std::size_t>(at, 2), 2, "mm") == 0 ? at - 2 : at;
      const auto first_mm = NumberBefore(text, first_end);
      const auto after = NumbersApart(text.substr(at + 3));
      const bool is_mm = text.find("mm", at) != std::string::npos;
      if (first_mm && !after.empty() && is_mm && *first_mm > 0 && after[0] > 0) {
        return {*first_mm, after[0]};
      }
    }
  }
  return {kUnknown, kUnknown};
}

// +1 where the tool goes inside the line, -1 outside; 0: nothing says so.
int SideIn(const std::string& lower) {
  const bool is_inside = lower.find("inside") != std::string::npos;
  const bool is_outside = lower.find("outside") != std::string::npos;
  return is_inside == is_outside ? 0 : is_inside ? 1 : -1;
}

std::string OfRatio(double ratio) {
  constexpr double kExact = 5e-4;
  struct Known {
    double ratio = 1;
    const char* words = nullptr;
  };
  constexpr std::array kRatios = {
      Known{96.0 / 90,
            "96 / 90, the pixels an inch of two programs that draw: one takes the "
            "drawing at 90, the other at 96. Set them alike"},
      Known{90.0 / 96,
            "90 / 96, the pixels an inch of two programs that draw: one takes the "
            "drawing at 96, the other at 90. Set them alike"},
      Known{72.0 / 96, "72 / 96, points taken for pixels. Set them alike"},
      Known{96.0 / 72, "96 / 72, pixels taken for points. Set them alike"},
      Known{25.4, "25.4, inches taken for millimetres. Set the unit"},
      Known{1 / 25.4, "1 / 25.4, millimetres taken for inches. Set the unit"}};
  for (const Known& known : kRatios) {
    if (std::abs(ratio / known.ratio - 1) < kExact)
      return fmt::format(" {:.4f} is {}", ratio, known.words);
  }
  return " Look at the scale, the unit and the tool there";
}

bool SaysWord(const std::string& lower, const std::string& word) {
  const std::vector<std::string> tokens = TokensOf(lower);
  return std::ranges::find(tokens, word) != tokens.end();
}

// Whether something was measured, too: a table beside the program.
bool HasTable(const std::string& text) {
  std::string others;
  for (const TextLine& line : LinesOf(text)) {
    const char first = line.text.front();
    const bool is_block =
        std::string_view("GMNgmn;(%").find(first) != std::string::npos;
    if (!is_block) others += std::string(line.text) + "\n";
  }
  return !TablesInText(others).empty();
}

}  // namespace

std::optional<FileNote> NoteOfDrawnPath(const std::string& text) {
  constexpr int kFewestMoves = 3;
  constexpr double kRight = 0.003, kAlike = 0.002;
  const std::string lower = Lowered(text);
  // Relative moves and inches are not added up here.
  if (SaysWord(lower, "g91") || SaysWord(lower, "g20") || HasTable(text)) {
    return std::nullopt;
  }
  const Extent2 extent = ExtentOf(text);
  const double tool_mm = ToolIn_mm(lower);
  const std::array<double, 2> drawn_mm = DrawnIn_mm(lower);
  const int side = SideIn(lower);
  const bool is_whole = extent.moves >= kFewestMoves && Known(tool_mm) &&
                        Known(drawn_mm[0]) && side != 0 && extent.Size_mm(0) > 0 &&
                        extent.Size_mm(1) > 0;
  if (!is_whole) return std::nullopt;
  const std::array made_mm = {extent.Size_mm(0) + side * tool_mm,
                              extent.Size_mm(1) + side * tool_mm};
  const std::array ratio = {made_mm[0] / drawn_mm[0], made_mm[1] / drawn_mm[1]};
  const bool is_right =
      std::abs(ratio[0] - 1) < kRight && std::abs(ratio[1] - 1) < kRight;
  const std::string path = fmt::format(
      "{:.4g} x {:.4g} mm of path with a tool of {:g} mm {} make {:.5g} x {:.5g} mm",
      extent.Size_mm(0),
      extent.Size_mm(1),
      tool_mm,
      side > 0 ? "inside" : "outside",
      made_mm[0],
      made_mm[1]);
  if (is_right) {
    return FileNote{.kind = FileNote::Kind::kOpen,
                    .what = "cause",
                    .sentence = fmt::format(
                        "what a part of another size comes from: the program is right "
                        "({}). Measure a move of the machine, and the tool",
                        path)};
  }
  // Off by two factors it may have been cut in passes, or parked elsewhere.
  if (std::abs(ratio[0] / ratio[1] - 1) > kAlike) return std::nullopt;
  FileNote note{
      .kind = FileNote::Kind::kElsewhere,
      .what = "file",
      .sentence = fmt::format(
          "The program already has the wrong size: {}, and {:g} x {:g} were drawn "
          "(path "
          "{:.4g} x {:.4g} would make it).{}. No setting of the machine is to be "
          "changed "
          "for it",
          path,
          drawn_mm[0],
          drawn_mm[1],
          drawn_mm[0] - side * tool_mm,
          drawn_mm[1] - side * tool_mm,
          OfRatio(ratio[0]))};
  note.fact = "known_ratio";
  note.word = "drawing";
  note.figures = {{"factor", ratio[0]}, {"made_mm", made_mm[0]}};
  return note;
}

Imported ReadDrawnPath(const std::string& text,
                       const std::string& name,
                       const ImportOptions& /*options*/) {
  const auto note = NoteOfDrawnPath(text);
  if (!note) {
    throw InputError(
        {.file = name, .line = 1, .column = 1},
        "no program beside what was drawn stands here",
        "moves (G1 X10 Y10), 'tool 3 mm', inside or outside, '40 x 30 mm'");
  }
  return {.recognised = {"a program's path beside what was drawn"}, .notes = {*note}};
}

}  // namespace caltwin
