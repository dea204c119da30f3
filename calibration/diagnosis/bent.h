#pragma once

#include <cstddef>
#include <vector>

#include "calibration/diagnosis/refit.h"

namespace caltwin {

/// A finding whose prediction is not straight in its sizes, at those that fit best.
///
/// refined.variant: its columns times its sizes are exactly what it does beside the
/// bent findings before it, so that together they do what the model says of all.
struct Bent {
  std::size_t finding = 0;  ///< Index in the search's.
  Refined refined{};
};

/// The pivots and swapped motors of a bed on screws, and the parts of a delta's chain
/// (IsRigid), among the findings, fitted together by Gauss-Newton rounds on the exact
/// prediction, the other findings and the baseline free. Their geometry has no freedom
/// of form.
///
///   change_k = f(v_1 .. v_k) - f(v_1 .. v_k-1)   [mm],  f reading predicted
///   column_kj = df/dv_kj + (change_k - sum_i v_ki df/dv_ki) v_kj / |v_k|^2
std::vector<Bent> Bend(const Observed& observed,
                       const std::vector<Candidate>& candidates,
                       const SearchResult& search);

/// Candidates whose columns are taken where they were found instead of at nought.
/// Returns whether any of them thereby does anything else to a row, by more than
/// `kFine` of the noise.
bool TakeWhereFound(const std::vector<Bent>& bent,
                    const SearchResult& search,
                    std::vector<Candidate>* candidates);

}  // namespace caltwin
