#pragma once

#include <fstream>
#include <map>
#include <string>

namespace caltwin {

inline constexpr const char* kBoundsFile =
    CALTWIN_SOURCE_DIR "/scenarios/studies/coverage/bounds.csv";

/// Cramer-Rao bounds of the procedures of the coverage studies, by "contender quantity"
/// and in the quantity's unit, as tests/scenarios/bounds_slow_test.cc makes them.
inline std::map<std::string, double> KeptBounds() {
  std::map<std::string, double> kept;
  std::ifstream file(kBoundsFile);
  std::string line;
  std::getline(file, line);  // The columns' names.
  while (std::getline(file, line)) {
    const std::size_t first = line.find(','), second = line.find(',', first + 1);
    const std::string name =
        line.substr(0, first) + " " + line.substr(first + 1, second - first - 1);
    kept[name] = std::stod(line.substr(second + 1));
  }
  return kept;
}

}  // namespace caltwin
