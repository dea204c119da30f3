#pragma once

#include <string_view>
#include <vector>

#include "calibration/diagnosis/search.h"

namespace caltwin {

/// Where something lies, the bed's plane too, is nobody's error: always fitted, however
/// badly it is known.
bool IsPlace(std::string_view line);

/// Whether rows say what a line of the baseline is: it leaves no row open by 50 um, and
/// half of what was known of it before is gone. `sd` in the line's unit.
bool IsDetermined(const Nuisance& line, double sd);

/// The baseline that tables are fitted beside. What both share, rows give to neither: a
/// slope along x is scale.x or part of a table over x. A line that the rows would
/// tell without a table, and with it not, or ten times worse, is not among them: it
/// stays as drawn and the table has it all, so that table and drawing together are what
/// was measured, in the extended machine and in a correction. Where things lie
/// (placements, the bed's height) stays the baseline's.
std::vector<Nuisance> LinesBesideTables(const Observed& observed,
                                        const std::vector<Candidate>& candidates,
                                        const SearchResult& search);

}  // namespace caltwin
