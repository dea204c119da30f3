#pragma once

#include <string>
#include <vector>

#include "tests/blind/diagnosis.h"

namespace blind {

/// What a diagnosis is worth at poses that nobody measured.
struct Volumetric {
  std::string name{};
  double sigma = 0;
  unsigned long long seed = 0;
  bool ran = false;
  double before_um = 0;  ///< Error beyond the baseline of the machine as drawn.
  double after_um = 0;   ///< The same of the machine as the diagnosis extended it.

  double Removed() const { return before_um > 0 ? 1 - after_um / before_um : 0; }
};

/// The same machine read without noise at 120 random poses of its travel, along x, y
/// and z, each axis approached from a side drawn for that pose. Only what the case
/// hides acts, not its wander, clutter or outliers.
void MakeUnseen(const Case& made, Case* unseen);

/// Hides a cause that moves the tool by where it stands, has it diagnosed from the
/// case's noisy rows, then has unseen rows predicted by the machine as drawn and as
/// extended. The rms that `caltwin diagnose --json` states of rows held out is taken of
/// both.
Volumetric ExamineVolumetric(const Diagnoser& diagnoser, const CaseRequest& request);

/// The requests: `count` of each of 3 and 20 sigma, causes in turn.
std::vector<CaseRequest> VolumetricSet(int count, std::uint64_t seed);

/// Median removed at each size against what must be, and every case that fell short.
std::string VolumetricText(const std::vector<Volumetric>& all);

}  // namespace blind
