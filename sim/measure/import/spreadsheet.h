#pragma once

#include <string>
#include <vector>

#include "sim/measure/csv.h"

namespace caltwin {

/// A table somebody saved as text, its form found out.
struct Spreadsheet {
  char separator = ',';  ///< A blank stands for any blanks.
  char decimal = '.';
  CsvRecord headings{};  ///< Empty where the first line holds numbers.
  std::vector<CsvRecord> records{};
};

/// What becomes of a cell that holds a place, "50,50" or "(50, 50)", in each line of a
/// column.
enum class PlaceCells {
  kAsTheyStand,
  kParted  ///< Into two columns, headed x and y.
};

/// Reads a table: the separator is the first of semicolon, tab, comma, blank that parts
/// the most lines in the same number of fields (two or more). The decimal mark is a
/// comma where numbers hold one, between digits, and none holds a dot. Lines above the
/// first of that number of fields (titles) are left out, `#` lines are comments. Throws
/// InputError, naming the line, where lines have other numbers of fields or where both
/// marks stand for decimals.
Spreadsheet ReadSpreadsheet(const std::string& text,
                            const std::string& name,
                            PlaceCells places = PlaceCells::kAsTheyStand);

}  // namespace caltwin
