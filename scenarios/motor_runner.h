#pragma once

#include "scenarios/runner.h"

namespace caltwin {

/// Runs a motor stage's scenario closed-loop and judges it: the procedures speak G-code
/// to the simulated controller and read the laser, nothing else.
///
/// Outcomes: `refused` (the operator was called), `alarm`, `no_trigger`, `confounded`
/// as the procedures ended; `recovers` where every estimate holds its truth within five
/// of its standard uncertainties (or what was expected, where that is wider), `misses`
/// else.
RunResult RunMotorScenario(const Scenario& scenario, const RunOptions& options);

}  // namespace caltwin
