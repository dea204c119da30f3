#pragma once

#include <string>
#include <vector>

#include "sim/measure/import/import.h"

namespace caltwin {

/// One assignment of `--map`, as written: `target=source[unit]` or `target:=constant`.
///
/// `target` is a column of measured rows, or `actual_mm`, the reading of a gauge along
/// the single commanded axis: then value_mm = actual - commanded. `source` is a
/// column's heading or its number from 1; a minus before it reverses the sign. `unit`
/// is one that is converted (unit.h), or `clock` for times of day. `unit=um` is the
/// unit of the value where none stands behind it. `dir_x:=order` takes the sense of
/// approach from the order of the commanded positions.
struct Assignment {
  std::string target{};
  std::string source{};  ///< Heading or number; the constant, where it is one.
  std::string unit{};
  bool is_constant = false;
  bool is_reversed = false;
};

/// Reads the words of `--map`, each of which may hold several, apart by commas. Throws
/// InputError with every fault.
std::vector<Assignment> ParseMap(const std::vector<std::string>& words);

/// Reads a spreadsheet saved as text: columns apart by commas, semicolons, tabs or
/// blanks, with a decimal point or comma (both found out), its columns named by
/// `options.map`. Without a heading line columns are told by number. Without a map the
/// columns are listed in the message.
Imported ReadMapped(const std::string& text,
                    const std::string& name,
                    const ImportOptions& options);

}  // namespace caltwin
