#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace caltwin {

/// How something that a report says is meant: it colours verdicts and badges.
enum class Tone { kGood, kWarn, kBad, kPlain };

/// "good", "warn", "bad", "plain": the class of the style sheet.
std::string_view ClassOf(Tone tone);

/// A word in a coloured pill.
std::string BadgeHtml(Tone tone, std::string_view word);

/// A cell of a table with a number, set to the right.
std::string NumberCell(std::string_view text);

/// A table that scrolls by itself where the screen is narrow. `caption` and `headings`
/// are text, `rows` is HTML; empty where there are no rows.
std::string TableHtml(std::string_view caption,
                      const std::vector<std::string>& headings,
                      std::string_view rows);

/// A drawing with its title and what to look for; `below` is HTML under it. Empty where
/// there is no drawing.
std::string FigureHtml(std::string_view title,
                       std::string_view caption,
                       std::string_view svg,
                       std::string_view below = "");

/// Texts as a list; one that occurs several times stands once, with how often. Empty
/// where there are none.
std::string ListHtml(const std::vector<std::string>& texts);

}  // namespace caltwin
