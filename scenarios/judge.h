#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calibration/loop/outcome.h"
#include "scenarios/expectation.h"
#include "scenarios/result.h"

namespace caltwin {

/// How far a machine truly is from right, in the one figure that its kind is calibrated
/// for: the position error of a gantry, the level of a bed, the nozzle's height.
struct TrueFigure {
  double before = 0, after = 0;
  double noise = 0;  ///< What it may grow by through chance alone.
  /// Whether `after` is as good as this kind asks for where the scenario asks for
  /// nothing.
  bool is_met = true;
};

/// What the truth says of a run's end, beside its rows.
struct TrueEnd {
  std::optional<TrueFigure> figure{};
  /// The error of what was calibrated grew in two or more passes.
  bool grew_twice = false;
  /// Something was told, or set, and is further from the truth than it may be; or
  /// nothing was told at all.
  bool told_wrong = false;
  /// A size was read as none where there is one.
  bool reads_zero = false;
};

/// Fills in tolerance and verdict of each row that is expected to be something. What
/// was expected and has no row is a check that fails, unless it was expected not to be
/// identifiable.
/// @return whether all of them are as expected
bool MeetExpectations(const Expectation& expect, RunResult* result);

/// How a run ended, in one word, on every kind of machine. The first of these that
/// holds:
/// - `diverges`: the error of what was calibrated grew in two or more passes, even if a
///   limit or an alarm then stopped it;
/// - `alarm`, `collision`, `no_trigger`: how the machine stopped a procedure;
/// - `refused`: a procedure was refused, which ends a run: by a limit, the operator, or
///   a check before;
/// - `reads_zero`: a procedure said so, or a size was read as none where there is one;
/// - `confounded`: a procedure said that it cannot tell;
/// - `diverges`: the figure that the kind is calibrated for is worse at truth than
///   before, by more than its noise;
/// - `misses`: all was done, but an expectation was not met, something told is wrong
///   (TrueEnd), or that figure is not what the kind asks for;
/// - `recovers`: none of these.
std::string JudgeOutcome(const std::vector<ProcedureResult>& results,
                         const TrueEnd& end,
                         bool all_met);

/// Every expectation of a row that is no `truth_within` as a check.
void CheckParameters(const Expectation& expect,
                     const std::vector<ProcedureResult>& results,
                     RunResult* result);

/// A check of a figure against what it must be above and below.
void CheckFigure(const FigureExpectation& expected, double found, RunResult* result);

/// A check for each text: whether something that was said holds it.
void CheckMessages(const std::vector<std::string>& texts,
                   const std::vector<ProcedureResult>& results,
                   RunResult* result);

/// A check, before all others, of how the run ended.
void CheckOutcome(const std::string& expected, RunResult* result);

/// Whether every check and every row passed, and the run came to its end.
bool AllPassed(const RunResult& result);

/// All steps of one quantity, in the order done.
std::vector<Step> StepsOf(const std::vector<ProcedureResult>& results,
                          const std::string& name);

}  // namespace caltwin
