#include <algorithm>
#include <string>

#include "sim/measure/import/fields.h"
#include "sim/measure/import/plain_table.h"

namespace caltwin {
namespace {

std::string Trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r*`");
  if (first == std::string_view::npos) return "";
  return std::string(text.substr(first, text.find_last_not_of(" \t\r*`") + 1 - first));
}

bool IsRule(std::string_view line) {
  return line.find('-') != std::string_view::npos &&
         line.find('|') != std::string_view::npos &&
         line.find_first_not_of("|-: \t\r") == std::string_view::npos;
}

// "| a | b |" as "a<tab>b"; lines that are no row of the table become empty, so that
// the others keep their numbers.
std::string FromMarkdown(const std::string& text) {
  std::string table;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.size(), text.find('\n', at));
    std::string line = Trimmed(std::string_view(text).substr(at, end - at));
    at = end + 1;
    if (line.find('|') == std::string::npos || IsRule(line)) {
      table += '\n';
      continue;
    }
    if (line.starts_with('|')) line.erase(0, 1);
    if (line.ends_with('|')) line.pop_back();
    for (std::size_t from = 0; from <= line.size();) {
      const std::size_t bar = std::min(line.size(), line.find('|', from));
      if (from > 0) table += '\t';
      table += Trimmed(std::string_view(line).substr(from, bar - from));
      from = bar + 1;
    }
    table += '\n';
  }
  return table;
}

// Cells of <td> and <th>, a line a <tr>.
std::string FromHtml(const std::string& text) {
  const std::string lower = Lowered(text);
  std::string table;
  bool is_cell = false, is_first = true;
  std::string cell;
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (text[at] == '\n') table += is_cell ? "" : "\n";
    if (text[at] != '<') {
      if (is_cell && text[at] != '\n') cell += text[at];
      continue;
    }
    const std::string_view tag = std::string_view(lower).substr(at, 5);
    if (tag.starts_with("<td") ||
        (tag.starts_with("<th") && !tag.starts_with("<thea"))) {
      is_cell = true;
      cell.clear();
    } else if (tag == "</td>" || tag == "</th>") {
      table += (is_first ? "" : "\t") + Trimmed(cell);
      is_cell = is_first = false;
    } else if (tag.starts_with("<tr")) {
      is_first = true;
    } else if (tag == "</tr>") {
      table += '\n';
      is_first = true;
    }
    at = std::min(text.find('>', at), text.size() - 1);
  }
  return table;
}

}  // namespace

std::string WithoutMarkup(const std::string& text) {
  const std::string head = Lowered(text.substr(0, 20'000));
  if (head.find("<tr") != std::string::npos && head.find("<td") != std::string::npos) {
    return FromHtml(text);
  }
  int rows = 0;
  bool has_rule = false;
  for (const TextLine& line : LinesOf(text)) {
    if (line.text.find('|') == std::string_view::npos) continue;
    ++rows;
    has_rule |= IsRule(line.text);
  }
  return rows >= 2 && has_rule ? FromMarkdown(text) : text;
}

}  // namespace caltwin
