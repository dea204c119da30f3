#pragma once

#include <string>
#include <vector>

#include "scenarios/delta_scenario.h"
#include "scenarios/result.h"

namespace caltwin {

/// A check of a figure against what it must be above and below.
void CheckFigure(const std::string& name,
                 const Within& within,
                 double found,
                 RunResult* result);

/// A check for each text: whether some message of the run holds it.
void CheckMessages(const std::vector<std::string>& texts, RunResult* result);

/// A check, before all others, of how the run ended.
void CheckOutcome(const std::string& expected, RunResult* result);

}  // namespace caltwin
