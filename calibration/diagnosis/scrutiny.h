#pragma once

#include <string>
#include <vector>

#include "calibration/diagnosis/search.h"

namespace caltwin {

/// What a search found, held against rows left out: findings that make them no likelier
/// go; causes that explain too little, or whose size the rows do not tell, lose their
/// names; tables without a name that foretell little go. Returns what there is to say
/// of those, else "".
std::string Scrutinise(const Observed& observed,
                       const std::vector<Candidate>& candidates,
                       SearchResult* search);

}  // namespace caltwin
