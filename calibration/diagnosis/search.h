#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "calibration/diagnosis/found.h"
#include "calibration/diagnosis/outliers.h"
#include "calibration/diagnosis/weighing.h"

namespace caltwin {

struct SearchOptions {
  int most_findings = 4;
  std::uint64_t seed = 1;
  /// Names (Candidate::Name) of what was found at another baseline, the first found
  /// first: looked at before anything else.
  std::vector<std::string> start{};
  /// Running numbers of rows that are far from all others of their place or surface, as
  /// they are seen before anything is fitted (facts.h): left out from the start.
  std::set<std::int64_t> far_rows{};
};

/// Everything the search knows at its end.
struct SearchResult {
  std::vector<Found> found{};
  Circumstances circumstances{};  ///< Baseline alone; sigma and outliers as judged.
  Weighing first{};               ///< Before anything was accepted.
  Richest richest{};
  double wander_mm2_per_s = 0;
};

/// Forward search with swaps and backward deletion (docs/diagnosis.md, "How a cause is
/// named"). `observed` holds the un-extended model.
SearchResult Search(const Observed& observed,
                    const std::vector<Candidate>& candidates,
                    const SearchOptions& options);

}  // namespace caltwin
