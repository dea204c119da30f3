#pragma once

#include <cstdint>
#include <set>
#include <vector>

#include "calibration/facts/levels.h"

namespace caltwin {

/// Takes readings far from the middle of their place out of `batches` and adds them to
/// `outliers`: bad where they stand alone, no other of their batch beside them and of
/// the place a third at most. `cells`: each place, whatever the homing. Where three
/// places or more are far from their later readings up to one moment, or from their
/// earlier ones from it on, something moved then: a fact, and no bad reading.
void LeaveOutFar(const std::vector<Rows>& cells,
                 std::vector<Rows>* batches,
                 double resolution_mm,
                 std::set<std::int64_t>* outliers,
                 Facts* facts);

/// The fact "outliers".
void AddOutliers(const std::set<std::int64_t>& outliers,
                 const Rows& rows,
                 Facts* facts);

/// Readings of one thing further apart than their stated uncertainties allow.
void AddContradiction(const std::vector<Rows>& batches,
                      const DataHeader& header,
                      Facts* facts);

}  // namespace caltwin
