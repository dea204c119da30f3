#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "calibration/diagnosis/outliers.h"
#include "calibration/diagnosis/weighing.h"

namespace caltwin {

struct SearchOptions {
  double min_effect_um = 0;  ///< Smaller is not of practical size; 0: half a sigma.
  int most_findings = 4;
  std::uint64_t seed = 1;
};

/// A rival of a finding.
struct Rival {
  std::size_t candidate = 0;
  double probability = 0;
  /// It could imitate the finding in these rows, whatever its probability.
  bool structural = false;
  double separation = 0;  ///< lambda_sep; the square of sigmas between both.
};

/// One cause found, before refinement.
struct Found {
  std::size_t candidate = 0;
  Variant variant{};
  Eigen::VectorXd sizes_mm{};
  double probability = 0;
  double log_odds = 0;
  double scale_mm = 0;
  bool lost_its_name = false;  ///< Deviates too far from its form: unknown.
  std::vector<Rival> rivals{};
  int num_rows = 0;  ///< That it rests on.
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

/// The free form in the variables of a finding that lost its name, in its place; the
/// finding itself where no free form has them. `circumstances`: the others found in the
/// baseline.
Found FreeInstead(const Observed& observed,
                  const std::vector<Candidate>& candidates,
                  const Circumstances& circumstances,
                  const Found& found);

/// What a finding adds to the nuisances while others are sought: its own sizes, free,
/// and its freedom of form.
std::vector<Nuisance> NuisancesOf(const Observed& observed,
                                  const Candidate& candidate,
                                  const Found& found);

}  // namespace caltwin
