#pragma once

#include <string>
#include <vector>

namespace caltwin {

/// A table that stands in a text among other lines.
struct TextTable {
  /// Its lines at the places they had, fields apart by tabs. A word behind all numbers
  /// of a column ("10 lifts") becomes its heading.
  std::string text{};
  std::string title{};  ///< The line before it; empty: none of its own.
  bool has_heading = false;
};

/// Every table that stands in a text among titles, remarks and rules: blocks of lines
/// of as many fields, the one of most numbers first, the others as they stand. A block
/// without a heading, of the fields of one above it, has that one's. Empty: no such
/// block, or a line beside one looks like one of its own that is damaged, and nothing
/// may be lost.
std::vector<TextTable> TablesInText(const std::string& text);

/// The text of the first of them; empty: none.
std::string TableInText(const std::string& text);

/// What sentences say of sizes and moves, as a table: "drew 40 x 40, burned 20 x 20",
/// "told 10, got 9.8", "30 mm cube" above "X 30.05". Empty: no such sentence.
std::string SentencesAsTable(const std::string& text);

/// The line before a table as the name of a campaign, "with_leadscrew_hmm_293": whole
/// words, 40 letters at most; "table_2" where it has none.
std::string CampaignNamed(const std::string& title, std::size_t number);

/// Lines that say what was drawn and what came of it by an arrow, "5 inch square
/// -> 4.98", each run of them a table. Sizes in inches where the line says so,
/// "(hundredths)" behind a number taken for that. Empty: fewer than three such lines.
std::vector<TextTable> ArrowTables(const std::string& text);

}  // namespace caltwin
