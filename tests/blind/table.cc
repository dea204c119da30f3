#include "tests/blind/table.h"

#include <algorithm>
#include <sstream>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace blind {
namespace {

std::vector<std::string> Split(const std::string& line) {
  std::vector<std::string> words(1);
  for (const char letter : line) {
    if (letter == ',') {
      words.emplace_back();
    } else {
      words.back() += letter;
    }
  }
  return words;
}

}  // namespace

int TextTable::Column(const std::string& name) const {
  const auto found = std::ranges::find(columns, name);
  return found == columns.end() ? -1 : static_cast<int>(found - columns.begin());
}

TextTable ParseTable(const std::string& text) {
  TextTable table;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (table.columns.empty()) {
      table.columns = Split(line);
    } else {
      table.rows.push_back(Split(line));
    }
  }
  return table;
}

std::string ToText(const TextTable& table) {
  std::string text = fmt::format("{}", fmt::join(table.columns, ",")) + "\n";
  for (const auto& row : table.rows) {
    text += fmt::format("{}", fmt::join(row, ",")) + "\n";
  }
  return text;
}

}  // namespace blind
