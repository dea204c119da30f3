#pragma once

#include <string>
#include <vector>

#include "calibration/loop/outcome.h"
#include "scenarios/expectation.h"
#include "scenarios/judge.h"
#include "scenarios/result.h"
#include "sim/effects/effect.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// All that a verdict on a gantry may look at: what was built, what the firmware
/// believed before and after, what the procedures said. The truth enters here.
struct GantryTruth {
  const Machine* machine = nullptr;
  const std::vector<Injected>* effects = nullptr;
  Settings before{};
  Settings after{};
  std::vector<ProcedureResult> results{};  ///< In the order performed.
  double position_error_before_mm = 0;     ///< p95.
  double position_error_after_mm = 0;
};

/// The table of injected and recovered, not judged yet.
///
/// Rows: what was injected, what the scenario gave the firmware wrongly, what an
/// estimate or a step named, what a file expects, in the catalog's order. `injected` is
/// the built value, the drawing's where no effect touches it. `recovered` is
/// - the firmware's setting at the end, for what has one, where a step or an external
///   program changed it (a change rolled back included);
/// - else the last estimate that was identifiable;
/// - none where the last word was "not identifiable", or where nothing looked at it.
std::vector<ParameterResult> MakeTable(const GantryTruth& truth,
                                       const Expectation& expect);

/// What is true of the end, the table judged (MeetExpectations):
/// - the error grew: of one parameter, two or more applied steps each left an error
///   against the built value that is larger than before the step, and larger than its
///   tolerance (else 3 sd of its last estimate);
/// - read as none: a backlash within 3 sd of 0, where the built one is further away;
/// - told wrong: nothing at all, or beyond its tolerance (else 4 of its sd, else half
///   of the error it had), or a setting was left further from the truth than it was
///   (beyond its tolerance, else 3 sd);
/// - the figure is the p95 of the position error, its noise a micrometre.
TrueEnd EndOfGantry(const GantryTruth& truth,
                    const std::vector<ParameterResult>& table);

}  // namespace caltwin
