#pragma once

#include <string>
#include <vector>

#include "calibration/diagnosis/diagnosis.h"

namespace caltwin {

/// One figure of a machine in two campaigns.
struct Change {
  std::string name{};  ///< "backlash.x", or of a finding "cyclic_lead.x" (its size).
  std::string unit{};
  double before = 0, before_sd = 0;
  double now = 0, now_sd = 0;
  double sigmas = 0;  ///< |now - before| over both uncertainties together.
  bool is_more_than_noise = false;
};

/// A campaign and what was made of it.
struct Diagnosed {
  const Observed& observed;
  const Diagnosis& diagnosis;
};

/// What changed from one campaign to a later one: every figure of the baseline that
/// both have (the places of things excepted: they are put anew each time), and every
/// finding of either, its peak compared.
///
/// A finding that one campaign has and the other has not is looked for there: its shape
/// as refined is fitted to the other's rows beside baseline and findings, so that a
/// campaign that could not have shown it has a large uncertainty and no change.
///
/// More than noise: beyond what the largest of that many comparisons of noise exceeds
/// once in a hundred times (Bonferroni).
std::vector<Change> ChangesSince(const Diagnosed& before, const Diagnosed& now);

}  // namespace caltwin
