#pragma once

#include <string>
#include <vector>

#include "calibration/loop/outcome.h"
#include "scenarios/expectation.h"
#include "scenarios/result.h"
#include "sim/effects/effect.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// All that a verdict may look at: what was built, what the firmware believed before
/// and after, what the procedures said. The truth enters here and nowhere else.
struct Trial {
  const Machine* machine = nullptr;
  const std::vector<Injected>* effects = nullptr;
  Settings before{};
  Settings after{};
  std::vector<ProcedureResult> results{};  ///< In the order performed.
  double position_error_before_mm = 0;     ///< p95.
  double position_error_after_mm = 0;
};

/// The table of injected and recovered.
///
/// Rows: what was injected, what the scenario gave the firmware wrongly, what an
/// estimate or a step named, what a file expects, in the catalog's order. `injected` is
/// the built value, the drawing's where no effect touches it. `recovered` is
/// - the firmware's setting at the end, for what has one, where a step or an external
///   program changed it (a change rolled back included);
/// - else the last estimate that was identifiable;
/// - none where the last word was "not identifiable", or where nothing looked at it.
/// A row passes where every expectation of its parameter holds; null where none was
/// given.
std::vector<ParameterResult> MakeTable(const Trial& trial, const Expectation& expect);

/// In one word, the first of these that holds:
/// - `alarm`, `collision`, `no_trigger`: how the machine stopped a procedure;
/// - `diverges`: of one parameter, two or more applied steps each left an error against
///   the built value that is larger than before the step, and larger than its
///   tolerance (else 3 sd of its last estimate), even if a limit then stopped it;
/// - `refused`: a procedure was refused and nothing was applied in the whole run;
/// - `reads_zero`: a procedure said so, or a backlash was read as 0 within 3 sd where
///   the built one is further away than that;
/// - `confounded`: a procedure said that it cannot tell;
/// - `misses`: all was done, yet nothing was told at all, or what was told is wrong
///   (beyond its tolerance, else 4 of its sd, else half of the error it had), or a
///   setting was left further from the truth than it was (beyond its tolerance, else 3
///   sd), or the p95 of the position error grew by more than a micrometre;
/// - `recovers`: none of these.
/// An alarm that ends a divergence is a divergence.
std::string JudgeOutcome(const Trial& trial, const std::vector<ParameterResult>& table);

/// Every expectation that is no truth_within as a check, the outcome first.
std::vector<CheckResult> MakeChecks(const Trial& trial,
                                    const Expectation& expect,
                                    const std::vector<ParameterResult>& table,
                                    const std::string& outcome);

}  // namespace caltwin
