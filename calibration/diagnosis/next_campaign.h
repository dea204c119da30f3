#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "calibration/diagnosis/candidates.h"
#include "calibration/diagnosis/diagnosis.h"
#include "calibration/diagnosis/search.h"
#include "sim/measure/plan.h"

namespace caltwin {

/// Rows with those of a planned session after them, as one table: ten minutes later,
/// homed and set up anew. Where the rows know no times, the planned ones know none.
Observed Followed(const Observed& observed, PlannedSession session);

/// The campaign, with its usual options along some axis, that would best settle what
/// the search left open: for a finding with named rivals the most sigmas gained
/// between it and each of them, per minute of machine time (first those that tell it
/// from all); for an unknown one the most that is learnt of its shape. None where
/// nothing is open, or nothing would help.
std::optional<NextCampaign> BestNext(const Observed& observed,
                                     const std::vector<Candidate>& candidates,
                                     const SearchResult& search,
                                     std::uint64_t seed);

}  // namespace caltwin
