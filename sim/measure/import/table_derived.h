#pragma once

#include <string>

#include "sim/measure/import/spreadsheet.h"

namespace caltwin {

/// Columns "A - 74" beside a column "A" are reckoned, and say what "A" should be: they
/// go, and a column "nominal" comes, where all of them say the same. What was found,
/// as a sentence; empty: nothing.
std::string DropDerived(Spreadsheet* sheet);

/// A column that says how far readings of one sense lie from those of the other ("even
/// rows vs odd rows", "forward - backward") becomes two lines each: the one sense as it
/// was read, the other at 0. Which of them is + is not known: the mean is taken as lost
/// motion. What was found, as a sentence; empty: nothing.
std::string PartSenses(Spreadsheet* sheet);

/// The length of a step in millimetres, where the text says that its readings count
/// steps and how many a millimetre has ("correction in steps, 80 steps/mm"); 0: it does
/// not.
double CountedStep_mm(const std::string& text);

}  // namespace caltwin
