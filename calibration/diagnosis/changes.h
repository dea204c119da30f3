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
  /// Whether the rows tell it beside all else that was fitted to them; where not, its
  /// value and uncertainty are its prior's.
  bool before_is_determined = true, now_is_determined = true;

  bool IsCompared() const { return before_is_determined && now_is_determined; }
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
/// Each campaign's figures are those of one fit: its baseline and the findings of both
/// campaigns, each in the shape that was refined (the later one's, where both have it).
/// So a figure means the same in both, and a campaign that could not have shown a
/// finding does not tell it. Uncertainties are from the scatter of the rows and allow
/// for what hangs together in time (TimeNoise). The shape of a finding counts as known.
///
/// More than noise: beyond what the largest of that many comparisons of noise exceeds
/// once in a hundred times (Bonferroni).
std::vector<Change> ChangesSince(const Diagnosed& before, const Diagnosed& now);

}  // namespace caltwin
