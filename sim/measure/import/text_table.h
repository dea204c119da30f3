#pragma once

#include <string>

namespace caltwin {

/// The table that stands in a text among other lines (titles, remarks, rules, a second
/// table), each of its lines at the place it had, fields apart by tabs: the block of
/// lines of as many fields that holds most numbers. A word behind all numbers of a
/// column ("10 lifts") becomes its heading. Empty: no such block, or a line outside it
/// looks like one of its own that is damaged, and nothing may be lost.
std::string TableInText(const std::string& text);

/// What sentences say of sizes and moves, as a table: "drew 40 x 40, burned 20 x 20",
/// "told 10, got 9.8", "30 mm cube" above "X 30.05". Empty: no such sentence.
std::string SentencesAsTable(const std::string& text);

}  // namespace caltwin
