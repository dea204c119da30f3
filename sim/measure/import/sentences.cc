#include <algorithm>
#include <array>
#include <cctype>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/measure/import/fields.h"
#include "sim/measure/import/text_table.h"

namespace caltwin {
namespace {

// Where the first of the words begins that stands by itself; npos.
template <std::size_t kNum>
std::size_t FirstOf(const std::string& line,
                    const std::array<std::string_view, kNum>& words) {
  std::size_t first = std::string::npos;
  for (const std::string_view word : words) {
    for (std::size_t at = line.find(word); at != std::string::npos;
         at = line.find(word, at + 1)) {
      const auto is_letter = [&](std::size_t i) {
        return i < line.size() &&
               std::isalpha(static_cast<unsigned char>(line[i])) != 0;
      };
      if ((at > 0 && is_letter(at - 1)) || is_letter(at + word.size())) continue;
      first = std::min(first, at);
      break;
    }
  }
  return first;
}

/// A size in a sentence, and the axis that the word behind it names; -1: none does.
struct Size {
  double value_mm = 0;
  int axis = -1;
};

int AxisOf(const std::string& word) {
  if (word == "wide" || word == "width" || word == "across") return 0;
  if (word == "tall" || word == "deep" || word == "long" || word == "up") return 1;
  if (word == "high" || word == "height" || word == "thick") return 2;
  return -1;
}

std::vector<Size> SizesIn(std::string_view text) {
  std::vector<Size> sizes;
  constexpr std::string_view kOfNumber = ".0123456789";
  for (std::size_t at = text.find_first_of(kOfNumber); at != std::string_view::npos;) {
    const std::size_t end =
        std::min(text.size(), text.find_first_not_of(kOfNumber, at));
    std::string number(text.substr(at, end - at));
    if (number.ends_with('.')) number.pop_back();
    if (const auto value = NumberOf(number)) {
      Size size{.value_mm = *value};
      std::size_t from = end;
      // "90 mm wide": the word behind the unit.
      for (int words = 0; words < 2 && size.axis < 0; ++words) {
        from = text.find_first_not_of(' ', from);
        if (from == std::string_view::npos) break;
        const std::size_t stop =
            std::min(text.size(), text.find_first_of(" ,.;)", from));
        size.axis = AxisOf(std::string(text.substr(from, stop - from)));
        from = stop;
      }
      sizes.push_back(size);
    }
    at = text.find_first_of(kOfNumber, end);
  }
  return sizes;
}

/// One size told and read.
struct Said {
  int line = 0;
  int axis = 0;
  double told_mm = 0, read_mm = 0;
};

// "drew 40 x 40, burned 20 x 20": as many sizes before the second word as behind it.
void AddToldAndRead(const std::string& line, int number, std::vector<Said>* said) {
  constexpr std::array<std::string_view, 10> kTold = {"drew",
                                                      "drawn",
                                                      "told",
                                                      "commanded",
                                                      "asked",
                                                      "should be",
                                                      "designed",
                                                      "ordered",
                                                      "programmed",
                                                      "sent"};
  constexpr std::array<std::string_view, 11> kRead = {"burned",
                                                      "came",
                                                      "got",
                                                      "measured",
                                                      "measures",
                                                      "moved",
                                                      "printed",
                                                      "cut",
                                                      "went",
                                                      "is",
                                                      "was"};
  const std::size_t told_at = FirstOf(line, kTold);
  if (told_at == std::string::npos) return;
  const std::string behind = line.substr(told_at);
  const std::size_t read_at = FirstOf(behind, kRead);
  if (read_at == std::string::npos) return;
  const std::vector<Size> told = SizesIn(std::string_view(behind).substr(0, read_at));
  std::vector<Size> read = SizesIn(std::string_view(behind).substr(read_at));
  // "burned 50 wide (49.8 with the calliper)": the last is the finer reading.
  if (told.size() == 1 && read.size() == 2 && read[1].axis < 0) {
    read[1].axis = read[0].axis;
    read = {read[1]};
  }
  if (told.empty() || told.size() > 3 || told.size() != read.size()) return;
  for (std::size_t k = 0; k < told.size(); ++k) {
    const int named = told[k].axis >= 0 ? told[k].axis : read[k].axis;
    said->push_back({number,
                     named >= 0 ? named : static_cast<int>(k),
                     told[k].value_mm,
                     read[k].value_mm});
  }
}

constexpr std::array<std::string_view, 8> kMovedWords = {
    "measured", "moved", "moves", "travelled", "travels", "goes", "went", "got"};

/// A move that a line of G-code tells, "g1x100" or "G0 X100 F500".
struct Told {
  int line = 0;
  int axis = 0;
  double told_mm = 0;
};

std::optional<Told> MoveIn(const std::string& line, int number) {
  if (!line.starts_with("g0") && !line.starts_with("g1")) return std::nullopt;
  std::optional<Told> told;
  for (std::size_t k = 2; k < line.size(); ++k) {
    if (line[k] < 'x' || line[k] > 'z') continue;
    std::string rest = line.substr(k + 1);
    rest = rest.substr(0, rest.find_first_not_of("-.0123456789"));
    const auto value_mm = NumberOf(rest);
    // Of two axes at once nothing says which was measured.
    if (!value_mm || *value_mm <= 0 || told) return std::nullopt;
    told = Told{number, line[k] - 'x', *value_mm};
  }
  return told;
}

// "measured: 51.66mm": one size behind the word.
std::optional<double> MeasuredIn(const std::string& line) {
  const std::size_t at = FirstOf(line, kMovedWords);
  if (at == std::string::npos) return std::nullopt;
  const std::vector<Size> sizes = SizesIn(std::string_view(line).substr(at));
  if (sizes.size() != 1) return std::nullopt;
  return sizes[0].value_mm;
}

// The size of a cube that a line speaks of; 0: none.
double CubeIn(const std::string& line) {
  const std::size_t cube = line.find("cube");
  if (cube == std::string::npos) return 0;
  const std::vector<Size> sizes = SizesIn(std::string_view(line).substr(0, cube));
  return sizes.size() == 1 ? sizes[0].value_mm : 0;
}

}  // namespace

std::string SentencesAsTable(const std::string& text) {
  std::vector<Said> said;
  double cube_mm = 0;
  std::optional<Told> move;
  for (const TextLine& line : LinesOf(text)) {
    std::string lower = Lowered(line.text);
    if (lower.starts_with("- ") || lower.starts_with("* ")) lower.erase(0, 2);
    // A move and, on the line below it, what was measured of it.
    constexpr int kBelow = 2;
    const auto measured_mm = MeasuredIn(lower);
    if (move && measured_mm && line.line <= move->line + kBelow)
      said.push_back({line.line, move->axis, move->told_mm, *measured_mm});
    // Both on one line: "G1 Y40   moves 20".
    move = MoveIn(lower.substr(0, FirstOf(lower, kMovedWords)), line.line);
    if (move && measured_mm) {
      said.push_back({line.line, move->axis, move->told_mm, *measured_mm});
      move.reset();
    }
    AddToldAndRead(lower, line.line, &said);
    if (const double size_mm = CubeIn(lower); size_mm > 0) cube_mm = size_mm;
    // "X 30.05", "y: 30.15 mm"
    const bool is_letter = lower.size() > 2 && lower[0] >= 'x' && lower[0] <= 'z' &&
                           std::isalpha(static_cast<unsigned char>(lower[1])) == 0;
    const std::vector<Size> sizes = is_letter ? SizesIn(lower) : std::vector<Size>();
    constexpr double kAlike = 0.2;
    const bool is_of_cube = cube_mm > 0 && sizes.size() == 1 &&
                            std::abs(sizes[0].value_mm / cube_mm - 1) < kAlike;
    if (is_of_cube)
      said.push_back({line.line, lower[0] - 'x', cube_mm, sizes[0].value_mm});
  }
  if (said.empty()) return "";
  std::string table = "axis,drawn,came out\n";
  int number = 2;
  for (const Said& one : said) {
    for (; number < one.line; ++number) table += '\n';
    table += fmt::format("{},{},{}\n", "xyz"[one.axis], one.told_mm, one.read_mm);
    ++number;
  }
  return table;
}

std::vector<TextTable> ArrowTables(const std::string& text) {
  constexpr std::size_t kFewest = 3;
  constexpr double kHundredth = 0.01;
  std::vector<TextTable> tables;
  std::string title;
  std::size_t num = 0;
  int number = 0;
  bool is_on = false;
  for (const TextLine& line : LinesOf(text)) {
    const std::string lower = Lowered(line.text);
    std::size_t arrow = std::min(lower.find("->"), lower.find("=>"));
    std::vector<Size> told, read;
    if (arrow != std::string::npos) {
      told = SizesIn(std::string_view(lower).substr(0, arrow));
      read = SizesIn(std::string_view(lower).substr(arrow + 2));
    }
    const bool is_off =
        arrow != std::string::npos && lower.find(" off", arrow) != std::string::npos;
    if (told.size() != 1 || read.size() != 1 || is_off) {
      title = line.text;
      is_on = false;
      continue;
    }
    if (!is_on) {
      tables.push_back({"drawn\tcame out\n", title});
      number = 2;
    }
    is_on = true;
    const bool is_hundredths = lower.find("hundredth", arrow) != std::string::npos;
    const bool is_told_in_inches = lower.find("inch") < arrow;
    const bool is_read_in_mm = lower.find("mm", arrow) != std::string::npos;
    const double told_unit = is_told_in_inches ? MmFromInch(1.0) : 1;
    const double read_unit = is_read_in_mm ? 1 : told_unit;
    for (; number < line.line; ++number) tables.back().text += '\n';
    tables.back().text +=
        fmt::format("{}\t{}\n",
                    told[0].value_mm * told_unit,
                    read[0].value_mm * read_unit * (is_hundredths ? kHundredth : 1));
    ++number;
    ++num;
  }
  return num >= kFewest ? tables : std::vector<TextTable>{};
}

}  // namespace caltwin
