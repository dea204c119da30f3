#pragma once

#include <string>
#include <vector>

#include "calibration/diagnosis/diagnosis.h"

namespace caltwin {

/// The smallest effect of one cause that rows would have shown.
struct WouldShow {
  std::string cause{};
  std::string axis{};
  /// Near-peak [mm] of what it would do; infinite: the baseline absorbs it.
  double smallest_mm = 0;
};

/// For each cause that fits the rows, the near-peak at which the part of it that the
/// baseline cannot imitate reaches 10 sigma in all, |M W Phi a| = 10 (below that, a
/// diagnosis may miss it). Forms in the middle of their grid; sigma is the diagnosis's
/// noise floor. Smallest first.
std::vector<WouldShow> WhatRowsWouldShow(const Observed& observed,
                                         const Diagnosis& diagnosis);

}  // namespace caltwin
