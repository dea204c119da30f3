#include "renders/parts.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "renders/html.h"

namespace caltwin {

std::string_view ClassOf(Tone tone) {
  switch (tone) {
    case Tone::kGood:
      return "good";
    case Tone::kWarn:
      return "warn";
    case Tone::kBad:
      return "bad";
    case Tone::kPlain:
      return "plain";
  }
  return "plain";
}

std::string BadgeHtml(Tone tone, std::string_view word) {
  return fmt::format(
      "<span class=\"badge {}\">{}</span>", ClassOf(tone), Escaped(word));
}

std::string NumberCell(std::string_view text) {
  return fmt::format("<td class=\"number\">{}</td>", Escaped(text));
}

std::string TableHtml(std::string_view caption,
                      const std::vector<std::string>& headings,
                      std::string_view rows) {
  if (rows.empty()) return "";
  std::string head;
  for (const std::string& heading : headings) {
    head += fmt::format("<th scope=\"col\">{}</th>", Escaped(heading));
  }
  return fmt::format(
      "<div class=\"scroll\" tabindex=\"0\"><table>\n<caption><span>{}</span></caption>"
      "\n<thead><tr>{}</tr></thead>\n<tbody>\n{}</tbody></table></div>\n",
      Escaped(caption),
      head,
      rows);
}

std::string FigureHtml(std::string_view title,
                       std::string_view caption,
                       std::string_view svg,
                       std::string_view below) {
  if (svg.empty()) return "";
  return fmt::format(
      "<figure class=\"drawing\">\n<figcaption><strong>{}</strong><p>{}</p>"
      "</figcaption>\n{}{}</figure>\n",
      Escaped(title),
      Escaped(caption),
      svg,
      below);
}

std::string ListHtml(const std::vector<std::string>& texts) {
  std::string items;
  std::set<std::string> said;
  for (const std::string& text : texts) {
    if (!said.insert(text).second) continue;
    const auto times = std::ranges::count(texts, text);
    items += fmt::format("<li>{}{}</li>\n",
                         SentenceHtml(text),
                         times > 1 ? fmt::format(" ({} times)", times) : "");
  }
  return items.empty() ? "" : "<ul>\n" + items + "</ul>\n";
}

}  // namespace caltwin
