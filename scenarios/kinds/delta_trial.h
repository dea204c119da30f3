#pragma once

#include <memory>
#include <string>
#include <vector>

#include "calibration/kinds/delta/link_probe.h"
#include "scenarios/kinds/delta_scenario.h"
#include "scenarios/kinds/delta_verdict.h"
#include "scenarios/kinds/nobody.h"
#include "sim/kinds/delta/twin.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {

/// A delta in a trial, calibrated over Marlin's wire. The nozzle's height over its bed
/// has to become a tenth of what it was.
class DeltaTrial : public KindTrial {
 public:
  DeltaTrial(const DeltaScenario& scenario,
             const Machine& machine,
             const Chance& chance);

  Link* wire() override { return &twin_->link(); }
  void Connect(Link* link) override;
  Bench* bench() override { return &bench_; }
  void BeginStep(const CalibrationStep& step) override;
  void EndStep(const CalibrationStep& step, ProcedureResult* done) override;
  void Finish(RunResult* result) override;
  void AddParameters(const Expectation& expect,
                     const std::vector<ProcedureResult>& results,
                     RunResult* result) override;
  TrueEnd End(const std::vector<ProcedureResult>& results, RunResult* result) override;
  double Figure(const std::string& name, const RunResult& result) override;

 private:
  DeltaScenario delta_;
  Machine machine_;
  BuiltDelta built_;
  std::unique_ptr<DeltaTwin> twin_;
  DeltaTruth truth_;
  NoGauges gauges_{};
  NoHands hands_{};
  Bench bench_{};
  bool is_first_ = true;
};

}  // namespace caltwin
