#pragma once

#include "scenarios/runner.h"

namespace caltwin {

/// Runs a scenario of a nozzle's height (`station:`) and judges it: Klipper's G-code on
/// one side, what is true of nozzle, switch, probe and plate on the other. In closed
/// form, whatever fidelity is asked for.
///
/// Outcomes: `refused`, `no_trigger` as the machine said it; `recovers` (the nozzle
/// commanded to 0 stands within 10 um of the print surface), `misses`.
RunResult RunZOffsetScenario(const Scenario& scenario, const RunOptions& options);

}  // namespace caltwin
