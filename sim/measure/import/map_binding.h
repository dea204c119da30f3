#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/measure/columns.h"
#include "sim/measure/import/map.h"
#include "sim/measure/import/spreadsheet.h"
#include "sim/measure/import/unit.h"

namespace caltwin {

/// An assignment with everything found: where it reads, and how it converts.
struct Bound {
  Assignment assignment{};
  const Column* column = nullptr;  ///< Null for kind, value_mm and actual_mm.
  std::size_t source = 0;
  const NamedUnit* unit = nullptr;
  bool is_clock = false;
  bool is_from_order = false;
};

/// A whole map bound to a sheet, and the units that nobody stated.
struct Binding {
  std::vector<Bound> columns{};
  std::vector<std::string> assumed{};
};

/// Finds every source of the map in the sheet and every unit. The unit behind a source
/// wins over its heading's, which must not contradict it; positions, times and
/// temperatures without either are taken in mm, s, degrees Celsius and said so; a
/// value's unit is never guessed. Throws InputError with every fault, and where the map
/// lacks what a row needs.
Binding Bind(const std::vector<Assignment>& map,
             const Spreadsheet& sheet,
             const std::string& name,
             const ImportOptions& options);

/// Whether the map names that column.
bool Names(const std::vector<Bound>& columns, std::string_view target);

}  // namespace caltwin
