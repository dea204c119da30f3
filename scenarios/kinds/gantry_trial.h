#pragma once

#include <optional>
#include <vector>

#include "scenarios/kinds/gantry_verdict.h"
#include "scenarios/runner.h"
#include "sim/twin/built.h"
#include "sim/twin/twin.h"

namespace caltwin {

/// The twin of a gantry's scenario before anything is calibrated: its numbers drawn,
/// the machine file's effects included. The same for the same seed and sample.
TwinConfig MakeTwinConfig(const Scenario& scenario, const RunOptions& options = {});

/// The machine as built, for a real controller: what its firmware believes is in its
/// `settings`, its table is empty.
Built BuiltUnderController(const TwinConfig& config);

/// 95 % quantile of the tip's position error [mm] at 1000 seeded poses within the
/// travel, each reached in the sense + + + and in - - -, the mean offset over all of
/// them removed. That offset is where the part's zero goes, so nobody cuts it.
double PositionErrorP95_mm(const Twin& twin);

/// A gantry in a trial.
class GantryTrial : public KindTrial {
 public:
  GantryTrial(const Scenario& scenario, const Chance& chance);

  Link* wire() override { return &twin_.link(); }
  void Connect(Link* link) override { bench_.link = link; }
  Bench* bench() override { return &bench_; }
  void Before(RunResult* result) override;
  void BeginStep(const CalibrationStep& step) override;
  void EndExternal(ProcedureResult* done) override;
  void Finish(RunResult* result) override;
  void AddParameters(const Expectation& expect,
                     const std::vector<ProcedureResult>& results,
                     RunResult* result) override;
  TrueEnd End(const std::vector<ProcedureResult>& results, RunResult* result) override;
  double Figure(const std::string& name, const RunResult& result) override;

 private:
  GantryTruth TruthFor(const RunResult& result,
                       const std::vector<ProcedureResult>& results) const;

  Twin twin_;
  Bench bench_{};
  RowTable rows_{};
  Settings before_step_{};
};

}  // namespace caltwin
