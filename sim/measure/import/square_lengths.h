#pragma once

#include <array>
#include <string>
#include <vector>

#include "sim/measure/import/import.h"
#include "sim/measure/import/table_columns.h"

namespace caltwin {

/// From where to where a length was measured [mm].
struct Corners {
  std::array<double, 3> from_mm{}, to_mm{};
};

/// A length from one corner to another, as two readings of a setup of its own: the
/// second is what the length is longer than between those corners.
void AddLength(const std::string& campaign,
               const std::string& line,
               const Corners& corners,
               double read_mm,
               const Place& place,
               Imported* imported);

/// Reads a table whose columns are the diagonals and sides of squares, a square a line:
/// "diagonal front left - rear right", "AC", "BD", "left edge". Corners as Marlin
/// counts them: A near left, B far left, C far right, D near right. False where it
/// holds no two diagonals; without a side the square is taken as one.
bool ReadSquares(const Spreadsheet& sheet, const std::string& name, Imported* imported);

}  // namespace caltwin
