#pragma once

#include <functional>
#include <string>
#include <vector>

#include "calibration/diagnosis/plausible.h"
#include "sim/measure/rows.h"

namespace caltwin {

/// A real axis measured by laser (tests/data/iso230).
inline RowTable RealAxis(const std::string& name) {
  return ReadRows(std::string(CALTWIN_SOURCE_DIR) + "/tests/data/iso230/" + name +
                  ".csv");
}

inline RowTable X() {
  return RealAxis("ess_target_x_2022-04");
}

/// Kinds of doubt about the rows, those that refuse them with an exclamation mark.
inline std::vector<std::string> KindsOf(const RowTable& table,
                                        const DataHeader& header = {},
                                        const Machine* machine = nullptr) {
  std::vector<std::string> kinds;
  for (const Doubt& doubt : Doubts(table, header, machine)) {
    kinds.push_back(doubt.kind + (doubt.refuse ? "!" : ""));
  }
  return kinds;
}

/// What is said of the real X axis after something was done to each row.
inline std::vector<std::string> KindsAfter(const std::function<void(Row*)>& act) {
  RowTable table = X();
  for (Row& row : table.rows) act(&row);
  return KindsOf(table);
}

}  // namespace caltwin
