#pragma once

#include <cstddef>
#include <vector>

#include "calibration/diagnosis/evidence.h"
#include "calibration/diagnosis/found.h"

namespace caltwin {

/// Adds to the rivals of a named finding every named cause that could imitate it in
/// these rows (lambda_sep below 9), whatever its probability, and where a jump stands
/// between two parts of an axis, the table of that axis; the likeliest first.
/// `beside`: with the baseline and the other findings. `finding`: which of `found`.
void AddImitators(const Observed& observed,
                  const std::vector<Candidate>& candidates,
                  const Evidence& beside,
                  std::size_t finding,
                  std::vector<Found>* found);

}  // namespace caltwin
