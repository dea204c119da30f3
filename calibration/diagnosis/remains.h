#pragma once

#include <vector>

#include "calibration/diagnosis/search.h"

namespace caltwin {

/// The noise of one reading of a campaign.
struct Floor {
  double sigma_mm = 0;
  double dof = 0;
};

/// By campaign: from replicates where there are ten degrees of freedom and no drift
/// between them raises it (not less than what whole motor steps leave open), else what
/// the richest model leaves.
std::vector<Floor> FloorsOf(const Observed& observed, const SearchResult& search);

/// What the baseline alone leaves, against the noise there is.
struct Remains {
  double rms_mm = 0;    ///< With slow wander taken for noise, if it can be told.
  double floor_mm = 0;  ///< As FloorsOf; where that has no rows to spare, stated.
  double chance = 1;    ///< That noise alone leaves so much more: Fisher's F.
  /// The wander is the fastest that is tried, and without it the rows are no noise:
  /// what they do may be no wander at all.
  bool wanders_most = false;

  /// Far more than noise: twice the floor, and no chance of one in ten thousand.
  /// Then "nothing but noise" would be untrue, named or not.
  bool IsThere() const;
};

Remains RemainsOf(const Observed& observed, const SearchResult& search);

}  // namespace caltwin
