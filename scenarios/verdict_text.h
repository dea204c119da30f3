#pragma once

#include <string>
#include <utility>
#include <vector>

#include "scenarios/result.h"

namespace caltwin {

/// How many of the things that a scenario expects came true, and of how many.
std::pair<int, int> Score(const RunResult& result);

/// What a run came to, for somebody who reads one sentence.
struct RunVerdict {
  std::string sentence{};
  /// What goes with it: why it went wrong, the first expectation that is not met, what
  /// the machine gained, that the run was broken off.
  std::vector<std::string> remarks{};
};

/// "The calibration recovered what was hidden in the machine: 3 of 3 expectations met."
RunVerdict VerdictOf(const RunResult& result);

}  // namespace caltwin
