#pragma once

#include "scenarios/runner.h"

namespace caltwin {

/// Runs a delta's scenario closed-loop and judges it: the procedures speak Marlin's
/// G-code to the twin (G33 runs in its firmware, the others touch by G30 and set M665
/// and M666), and see neither what it is built like nor each other.
///
/// Outcomes: `recovers` (every expected value met and the heights a tenth of what they
/// were), `misses`, `diverges` (heights twice as bad), `no_trigger` (a touch was out of
/// reach).
RunResult RunDeltaScenario(const Scenario& scenario, const RunOptions& options);

}  // namespace caltwin
