#pragma once

#include "sim/measure/import/import.h"
#include "sim/measure/import/spreadsheet.h"

namespace caltwin {

/// Where a column of a table is the difference of two others, line by line: a work
/// offset that a routine forgot, or an artefact that is not what it is believed to be.
/// Such an error is none of the machine's.
void AddDifferences(const Spreadsheet& sheet, Imported* imported);

}  // namespace caltwin
