#pragma once

#include <string_view>

#include "calibration/diagnosis/search.h"

namespace caltwin {

/// Where something lies is nobody's error: always fitted, however badly it is known.
bool IsPlace(std::string_view line);

/// Whether rows say what a line of the baseline is: it leaves no row open by 50 um, and
/// half of what was known of it before is gone. `sd` in the line's unit.
bool IsDetermined(const Nuisance& line, double sd);

/// What a baseline and the tables found beside it share, rows give to neither: a slope
/// along x is scale.x or part of a table over x. Where a table leaves a line of the
/// baseline undetermined, which the rows would tell without it, the line stays as drawn
/// and the table is fitted without it: then table and drawing together are what was
/// measured, in the extended machine and in a correction. Where things lie
/// (placements, the bed's height) stays the baseline's.
void CompleteTables(const Observed& observed,
                    const std::vector<Candidate>& candidates,
                    SearchResult* search);

}  // namespace caltwin
