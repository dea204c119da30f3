#pragma once

#include <string>
#include <vector>

#include "sim/measure/import/table_columns.h"

namespace caltwin {

/// Gives a part to the columns whose headings say nothing, by what stands in them and
/// beside them; a sentence in `taken` for each.
void TakePartsByNumbers(const Spreadsheet& sheet,
                        std::vector<TableColumn>* columns,
                        std::vector<std::string>* taken);

}  // namespace caltwin
