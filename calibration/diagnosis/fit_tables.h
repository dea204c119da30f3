#pragma once

#include <vector>

#include "calibration/diagnosis/refit.h"

namespace caltwin {

/// Sizes of the tables among what was found, beside the named findings as they were
/// fitted, held back no more than the gain says of them (NuisancesOf): what the
/// likeliest prior size holds back would stay in the rows, and be found there again.
///
/// What a plate that leans otherwise would make of a table, where the rows do not tell
/// how it leans, is taken out of it.
void FitTables(const Observed& observed,
               const std::vector<Candidate>& candidates,
               const SearchResult& search,
               std::vector<Refined>* refined);

}  // namespace caltwin
