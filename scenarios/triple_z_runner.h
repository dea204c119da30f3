#pragma once

#include "scenarios/runner.h"

namespace caltwin {

/// Runs a triple-Z printer's scenario closed-loop and judges it: the procedures speak
/// RepRapFirmware's G-code to the twin and see nothing else of it.
///
/// Outcomes: `alarm`, `no_trigger`, `refused`, `confounded` as a procedure ended;
/// `diverges` (the tilt grew in two rounds or more); `recovers` (every expected value
/// met, and where something levelled, the bed a tenth as tilted as before and within
/// the published 0.1 mm of its reference); `misses`.
RunResult RunTripleZScenario(const Scenario& scenario, const RunOptions& options);

}  // namespace caltwin
