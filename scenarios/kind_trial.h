#pragma once

#include <string>
#include <vector>

#include "calibration/loop/bench.h"
#include "calibration/loop/outcome.h"
#include "scenarios/judge.h"
#include "scenarios/result.h"
#include "sim/link/link.h"

namespace caltwin {

struct CalibrationStep;

/// A simulated machine in a trial: its wire, what a person has at it, and the truth,
/// which the judge alone asks for. scenarios/runner.cc leads every trial the same way:
///
///   Before, Connect, (BeginStep, the step, EndStep) for each, Finish, AddParameters,
///   End, Figure
class KindTrial {
 public:
  virtual ~KindTrial() = default;

  /// The machine's own wire.
  virtual Link* wire() = 0;
  /// From now on everything is said over `link`: the wire, with others listening in.
  virtual void Connect(Link* link) = 0;
  /// What `gcode` and `external` work on. Its link is that one, heard by all that
  /// follows what the machine is told.
  virtual Bench* bench() = 0;

  /// Fills in what is true before anything is done.
  virtual void Before(RunResult* /*result*/) {}
  virtual void BeginStep(const CalibrationStep& /*step*/) {}
  virtual void EndStep(const CalibrationStep& /*step*/, ProcedureResult* /*done*/) {}
  /// After an external program: what it changed and handed in becomes steps.
  virtual void EndExternal(ProcedureResult* /*done*/) {}
  /// Fills in rows and header, touches, machine time, and what is true at the end.
  virtual void Finish(RunResult* result) = 0;

  /// Adds the rows of injected and recovered, not judged yet; there may be none.
  virtual void AddParameters(const Expectation& /*expect*/,
                             const std::vector<ProcedureResult>& /*results*/,
                             RunResult* /*result*/) {}
  /// What is true of the end, its messages added; the rows have been judged.
  virtual TrueEnd End(const std::vector<ProcedureResult>& results,
                      RunResult* result) = 0;
  /// A figure of Expectable; not a number where the run has none.
  virtual double Figure(const std::string& name, const RunResult& result) = 0;
};

}  // namespace caltwin
