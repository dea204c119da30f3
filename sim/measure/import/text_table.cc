#include "sim/measure/import/text_table.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>
#include <string_view>
#include <vector>

#include <fmt/format.h>

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

// Without a remark in brackets at the end: "97.67  (again, other end)".
std::string_view WithoutRemark(std::string_view line) {
  const std::size_t open = line.rfind('(');
  const bool is_last =
      open != std::string_view::npos && open > 0 && line.ends_with(')');
  if (!is_last || line.find(' ', open) == std::string_view::npos) return line;
  return line.substr(0, open);
}

Fields FieldsOf(std::string_view whole, Part part) {
  const std::string_view line = WithoutRemark(whole);
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
  /// The first line that is its own.
  std::size_t first() const { return heading < begin ? heading : begin; }
};

class Finder {
 public:
  explicit Finder(const std::string& text) {
    for (const TextLine& line : LinesOf(text)) {
      lines_.push_back(line.text);
      numbers_.push_back(line.line);
    }
  }

  std::vector<TextTable> Find() {
    std::vector<Block> blocks = Apart(AllBlocks());
    // So many are no tables of one machine: the largest counts.
    constexpr std::size_t kMostTables = 12;
    if (blocks.size() > kMostTables) blocks.resize(1);
    if (blocks.empty() || std::ranges::any_of(blocks, [&](const Block& block) {
          return HasDamaged(block, blocks);
        })) {
      return {};
    }
    // The one of most numbers first, the others as they stand.
    std::sort(blocks.begin() + 1, blocks.end(), [](const Block& a, const Block& b) {
      return a.begin < b.begin;
    });
    std::vector<TextTable> tables;
    for (const Block& block : blocks) {
      const Block whole = WithHeading(blocks, block);
      tables.push_back({TextOf(whole), TitleOf(block, blocks), whole.has_heading()});
    }
    return tables;
  }

 private:
  // Every block that could be a table, and such as only have the fields of one.
  std::vector<Block> AllBlocks() const {
    std::vector<Block> all;
    for (const Part part : kParts) {
      for (std::size_t i = 0; i < lines_.size();) {
        const Block block = BlockFrom(i, part);
        i = std::max(block.end, i + 1);
        if (block.numbers > 0) all.push_back(block);
      }
    }
    // A heading counts as much as another column.
    std::ranges::stable_sort(all, std::ranges::greater{}, [](const Block& block) {
      return block.numbers + (block.has_heading() ? block.end - block.begin : 0);
    });
    constexpr std::size_t kMost = 100;
    if (all.size() > kMost) all.resize(kMost);
    return all;
  }

  // Those that do not stand in each other's way, most numbers first. Too short ones
  // stay where they have the fields of a longer one.
  static std::vector<Block> Apart(const std::vector<Block>& all) {
    std::vector<Block> apart;
    const auto is_free = [&](const Block& block) {
      return std::ranges::none_of(apart, [&](const Block& other) {
        return block.first() < other.end && other.first() < block.end;
      });
    };
    const auto is_long = [](const Block& block) {
      return block.end - block.begin >= (block.has_heading() ? 2U : 3U);
    };
    for (const Block& block : all) {
      if (is_long(block) && is_free(block)) apart.push_back(block);
    }
    const std::size_t num_long = apart.size();
    for (const Block& block : all) {
      const bool is_alike =
          !is_long(block) &&
          std::any_of(apart.begin(),
                      apart.begin() + static_cast<std::ptrdiff_t>(num_long),
                      [&](const Block& other) {
                        return other.part == block.part && other.fields == block.fields;
                      });
      if (is_alike && is_free(block)) apart.push_back(block);
    }
    return apart;
  }

  // A block without a heading has that of one above it of as many fields.
  static Block WithHeading(const std::vector<Block>& blocks, Block block) {
    if (block.has_heading()) return block;
    const Block* nearest = nullptr;
    for (const Block& other : blocks) {
      const bool is_above = other.has_heading() && other.end <= block.begin &&
                            other.part == block.part && other.fields == block.fields;
      if (is_above && (nearest == nullptr || other.begin > nearest->begin)) {
        nearest = &other;
      }
    }
    if (nearest == nullptr) return block;
    block.heading = nearest->heading;
    block.lacks_first = nearest->lacks_first;
    return block;
  }

  std::string TitleOf(const Block& block, const std::vector<Block>& blocks) const {
    std::size_t above = block.first();
    while (above > 0 && IsRule(lines_[above - 1])) --above;
    if (above == 0) return "";
    const bool is_of_another = std::ranges::any_of(blocks, [&](const Block& other) {
      return above > other.first() && above <= other.end;
    });
    return is_of_another ? "" : std::string(lines_[above - 1]);
  }

  static bool IsRule(std::string_view line) {
    return line.find_first_not_of("-_=|:;,+ \t") == std::string_view::npos;
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
    const bool is_sentence = part == Part::kBlanks && IsSentence(fields.front());
    return fields.size() >= 2 && CountedIn(fields.back()) && is_enough && !is_sentence;
  }

  // Words and a number in one cell.
  static bool IsSentence(const std::string& field) {
    constexpr auto kMostWords = 3;
    return std::ranges::count(field, ' ') >= kMostWords &&
           field.find_first_of("0123456789") != std::string::npos;
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

  // A line beside it that has as many fields and a number in one: a row gone wrong.
  bool HasDamaged(const Block& block, const std::vector<Block>& blocks) const {
    if (block.part == Part::kColon || block.part == Part::kBlank) return false;
    const auto is_row_gone_wrong = [&](std::size_t i) {
      const bool is_of_any = std::ranges::any_of(blocks, [&](const Block& other) {
        return i >= other.first() && i < other.end;
      });
      if (is_of_any) return false;
      const Fields fields = FieldsOf(lines_[i], block.part);
      // "probe z offset,-1.35,": a remark that has a figure.
      const bool is_remark =
          !CountedIn(fields.front()) && fields.back().empty() && !HasNames(block);
      return fields.size() == block.fields && NumbersIn(fields) > 0 && !is_remark;
    };
    // Up and down to the next line that is something else.
    for (std::size_t i = block.end; i < lines_.size(); ++i) {
      if (numbers_[i] > numbers_[i - 1] + 1 || IsRule(lines_[i])) break;
      if (is_row_gone_wrong(i)) return true;
      if (FieldsOf(lines_[i], block.part).size() != block.fields) break;
    }
    for (std::size_t i = block.first(); i > 0; --i) {
      if (numbers_[i] > numbers_[i - 1] + 1 || IsRule(lines_[i - 1])) break;
      if (is_row_gone_wrong(i - 1)) return true;
      if (FieldsOf(lines_[i - 1], block.part).size() != block.fields) break;
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

std::string CampaignNamed(const std::string& title, std::size_t number) {
  constexpr std::size_t kLongest = 40;
  std::string name, word;
  for (const char c : Lowered(title) + " ") {
    // Letters of other alphabets stand for nothing.
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c < 0;
    if (is_plain) {
      if (c > 0) word += c;
      continue;
    }
    if (name.size() + word.size() + 1 > kLongest) break;
    if (!word.empty()) name += (name.empty() ? "" : "_") + word;
    word.clear();
  }
  return name.empty() ? fmt::format("table_{}", number) : name;
}

std::vector<TextTable> TablesInText(const std::string& text) {
  return Finder(text).Find();
}

std::string TableInText(const std::string& text) {
  const std::vector<TextTable> tables = TablesInText(text);
  return tables.empty() ? "" : tables.front().text;
}

}  // namespace caltwin
