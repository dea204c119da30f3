#include "sim/measure/import/text_table.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>
#include <string_view>
#include <vector>

#include "sim/measure/import/fields.h"

namespace caltwin {
namespace {

using Fields = std::vector<std::string>;

/// How a line is parted: at bars, semicolons, tabs, two blanks or more, its last colon,
/// commas, blanks.
enum class Part { kBar, kSemicolon, kTab, kBlanks, kColon, kComma, kBlank };
constexpr std::array kParts = {Part::kBar,
                               Part::kSemicolon,
                               Part::kTab,
                               Part::kBlanks,
                               Part::kColon,
                               Part::kComma,
                               Part::kBlank};

std::string Trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r*`\"");
  if (first == std::string_view::npos) return "";
  return std::string(
      text.substr(first, text.find_last_not_of(" \t\r*`\"") + 1 - first));
}

Fields At(std::string_view line, char mark) {
  Fields fields;
  for (std::size_t from = 0; from <= line.size();) {
    const std::size_t end = std::min(line.size(), line.find(mark, from));
    fields.push_back(Trimmed(line.substr(from, end - from)));
    from = end + 1;
  }
  return fields;
}

Fields AtBlanks(std::string_view line, std::size_t fewest) {
  Fields fields;
  for (std::size_t from = 0; from < line.size();) {
    std::size_t end = from;
    while (end < line.size()) {
      std::size_t blank = std::min(line.size(), line.find_first_of(" \t", end));
      std::size_t after = std::min(line.size(), line.find_first_not_of(" \t", blank));
      if (after - blank >= fewest || after == line.size()) {
        end = blank;
        break;
      }
      end = after;
    }
    fields.push_back(Trimmed(line.substr(from, end - from)));
    from = std::min(line.size(), line.find_first_not_of(" \t", end));
  }
  return fields;
}

Fields FieldsOf(std::string_view line, Part part) {
  switch (part) {
    case Part::kBar: {
      Fields fields = At(line, '|');
      if (!fields.empty() && fields.front().empty()) fields.erase(fields.begin());
      if (!fields.empty() && fields.back().empty()) fields.pop_back();
      return fields;
    }
    case Part::kSemicolon:
      return At(line, ';');
    case Part::kTab:
      return At(line, '\t');
    case Part::kBlanks:
      return AtBlanks(line, 2);
    case Part::kColon: {
      const std::size_t colon = line.rfind(':');
      if (colon == std::string_view::npos) return {};
      return {Trimmed(line.substr(0, colon)), Trimmed(line.substr(colon + 1))};
    }
    case Part::kComma:
      return At(line, ',');
    case Part::kBlank:
      return AtBlanks(line, 1);
  }
  return {};
}

/// A number and the word behind it: "10 lifts", "49.8mm".
struct Counted {
  std::string number{};
  std::string word{};
};

std::optional<Counted> CountedIn(std::string text) {
  if (text.starts_with('+')) text.erase(0, 1);
  const std::size_t end =
      std::min(text.size(), text.find_first_not_of("-.,0123456789"));
  const std::string number = text.substr(0, end);
  const std::string word = Trimmed(std::string_view(text).substr(end));
  constexpr std::size_t kLongest = 8;
  const bool is_word = word.size() <= kLongest &&
                       word.find_first_of(" .,;:0123456789") == std::string::npos;
  if (!is_word || (!NumberOf(number) && !NumberOf(number, ','))) return std::nullopt;
  return Counted{number, word};
}

/// Lines from `begin` to `end` that are rows of one table.
struct Block {
  std::size_t heading = 0;  ///< Index of its line; `begin` where there is none.
  std::size_t begin = 0, end = 0, fields = 0, numbers = 0;
  Part part = Part::kBar;
  bool lacks_first =
      false;  ///< Nothing stands above the first column, which has names.

  bool has_heading() const { return heading != begin; }
};

class Finder {
 public:
  explicit Finder(const std::string& text) {
    for (const TextLine& line : LinesOf(text)) {
      lines_.push_back(line.text);
      numbers_.push_back(line.line);
    }
  }

  std::string Find() {
    Block best;
    for (const Part part : kParts) {
      for (std::size_t i = 0; i < lines_.size();) {
        const Block block = BlockFrom(i, part);
        i = std::max(block.end, i + 1);
        const std::size_t rows = block.end - block.begin;
        const bool is_enough = rows >= (block.has_heading() ? 2U : 3U);
        if (is_enough && block.numbers > best.numbers) best = block;
      }
    }
    if (best.numbers == 0 || HasDamaged(best)) return "";
    return TextOf(best);
  }

 private:
  static bool IsRule(std::string_view line) {
    return line.find_first_not_of("-_=|:+ \t") == std::string_view::npos;
  }

  static std::size_t NumbersIn(const Fields& fields) {
    return static_cast<std::size_t>(std::ranges::count_if(
        fields, [](const std::string& field) { return CountedIn(field).has_value(); }));
  }

  // Numbers in the last field and in half of them at least.
  static bool IsRow(const Fields& fields, Part part) {
    const std::size_t numbers = NumbersIn(fields);
    // What stands before a colon is mostly a sentence.
    const bool is_enough =
        part == Part::kColon ? numbers == fields.size() : 2 * numbers >= fields.size();
    return fields.size() >= 2 && CountedIn(fields.back()) && is_enough;
  }

  Block BlockFrom(std::size_t first, Part part) const {
    Block block{.heading = first, .begin = first, .end = first, .part = part};
    for (std::size_t i = first; i < lines_.size(); ++i) {
      if (IsRule(lines_[i]) && i > first) continue;
      const Fields fields = FieldsOf(lines_[i], part);
      if (!IsRow(fields, part)) break;
      if (block.fields > 0 && fields.size() != block.fields) break;
      block.fields = fields.size();
      block.numbers += NumbersIn(fields);
      block.end = i + 1;
    }
    if (block.end == first) return block;
    std::size_t above = first;
    while (above > 0 && IsRule(lines_[above - 1])) --above;
    if (above == 0) return block;
    const Fields heading = FieldsOf(lines_[above - 1], part);
    block.lacks_first = heading.size() + 1 == block.fields && heading.size() > 1 &&
                        part == Part::kBlanks && HasNames(block);
    const bool is_whole = heading.size() == block.fields || block.lacks_first;
    if (part != Part::kColon && is_whole && !IsRow(heading, part)) {
      block.heading = above - 1;
    }
    return block;
  }

  // Whether every row begins with a word.
  bool HasNames(const Block& block) const {
    for (std::size_t i = block.begin; i < block.end; ++i) {
      const Fields fields = FieldsOf(lines_[i], block.part);
      if (fields.size() == block.fields && CountedIn(fields[0])) return false;
    }
    return true;
  }

  // Whether every row begins with the letter of an axis.
  bool HasAxes(const Block& block) const {
    for (std::size_t i = block.begin; i < block.end; ++i) {
      const Fields fields = FieldsOf(lines_[i], block.part);
      const std::string name = fields.empty() ? "" : Lowered(fields[0]);
      if (fields.size() == block.fields && name != "x" && name != "y" && name != "z")
        return false;
    }
    return true;
  }

  // A line outside that has as many fields and a number in one: a row gone wrong.
  bool HasDamaged(const Block& block) const {
    if (block.part == Part::kColon || block.part == Part::kBlank) return false;
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      if (i == block.heading || (i >= block.begin && i < block.end)) continue;
      const Fields fields = FieldsOf(lines_[i], block.part);
      if (fields.size() == block.fields && NumbersIn(fields) > 0) return true;
    }
    return false;
  }

  // The same word behind each number of a column; empty: none, or several.
  std::string WordOf(const Block& block, std::size_t column) const {
    std::string word;
    for (std::size_t i = block.begin; i < block.end; ++i) {
      const Fields fields = FieldsOf(lines_[i], block.part);
      if (fields.size() != block.fields) continue;
      const auto counted = CountedIn(fields[column]);
      if (!counted || counted->word.empty()) return "";
      if (!word.empty() && counted->word != word) return "";
      word = counted->word;
    }
    return word;
  }

  std::string TextOf(const Block& block) const {
    Fields words;
    for (std::size_t k = 0; k < block.fields; ++k) words.push_back(WordOf(block, k));
    Fields heading;
    if (block.has_heading()) heading = FieldsOf(lines_[block.heading], block.part);
    if (block.has_heading() && block.lacks_first)
      heading.insert(heading.begin(), HasAxes(block) ? "axis" : "part");
    const bool has_words = std::ranges::any_of(
        words, [](const std::string& word) { return !word.empty(); });
    std::string text;
    int line = 1;
    const auto go_to = [&](int number) {
      for (; line < number; ++line) text += '\n';
    };
    const auto add = [&](const Fields& fields) {
      for (std::size_t k = 0; k < fields.size(); ++k)
        text += (k > 0 ? "\t" : "") + fields[k];
    };
    if (block.has_heading()) {
      go_to(numbers_[block.heading]);
      add(heading);
    } else if (has_words) {
      go_to(std::max(1, numbers_[block.begin] - 1));
      Fields made;
      for (std::size_t k = 0; k < words.size(); ++k)
        made.push_back(words[k].empty() ? "reading" : words[k]);
      add(made);
    }
    for (std::size_t i = block.begin; i < block.end; ++i) {
      Fields fields = FieldsOf(lines_[i], block.part);
      if (fields.size() != block.fields) continue;
      for (std::size_t k = 0; k < fields.size(); ++k) {
        // A unit stays, for the reader of cells to find.
        const bool is_made = !block.has_heading() && !words[k].empty();
        if (is_made) fields[k] = CountedIn(fields[k])->number;
      }
      go_to(text.empty() ? numbers_[i] : std::max(numbers_[i], line + 1));
      add(fields);
    }
    return text + "\n";
  }

  std::vector<std::string_view> lines_{};
  std::vector<int> numbers_{};
};

}  // namespace

std::string TableInText(const std::string& text) {
  return Finder(text).Find();
}

}  // namespace caltwin
