#pragma once

#include "calibration/diagnosis/search.h"

namespace caltwin {

/// What the baseline alone leaves, against the noise there is.
struct Remains {
  double rms_mm = 0;  ///< With slow wander taken for noise, if it can be told.
  double floor_mm =
      0;              ///< Of the richest model; where it has no rows to spare, stated.
  double chance = 1;  ///< That noise alone leaves so much more: Fisher's F.

  /// Far more than noise: three times the floor, and no chance of one in ten thousand.
  /// Then "nothing but noise" would be untrue, named or not.
  bool IsThere() const;
};

Remains RemainsOf(const Observed& observed, const SearchResult& search);

}  // namespace caltwin
