#pragma once

#include <string>
#include <vector>

namespace blind {

/// A table of text: measured rows as written.
struct TextTable {
  std::vector<std::string> columns{};
  std::vector<std::vector<std::string>> rows{};

  int Column(const std::string& name) const;  ///< -1: there is none.
};
TextTable ParseTable(const std::string& text);
std::string ToText(const TextTable& table);

}  // namespace blind
