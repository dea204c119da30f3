#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "calibration/kinds/motor_stage/motor_axes.h"
#include "scenarios/kinds/motor_stage_scenario.h"
#include "scenarios/kinds/motor_stage_wire.h"
#include "scenarios/kinds/nobody.h"

namespace caltwin {

/// A motor stage in a trial: the procedures speak G-code to the simulated controller
/// and read the laser, nothing else. What is told has to hold its truth within five of
/// its standard uncertainties (or what was expected, where that is wider).
class MotorStageTrial : public KindTrial {
 public:
  MotorStageTrial(const MotorStageScenario& scenario,
                  const std::filesystem::path& file,
                  const Chance& chance);

  Link* wire() override { return &wire_; }
  void Connect(Link* link) override;
  Bench* bench() override { return &bench_; }
  void EndStep(const CalibrationStep& step, ProcedureResult* done) override;
  void Finish(RunResult* result) override;
  void AddParameters(const Expectation& expect,
                     const std::vector<ProcedureResult>& results,
                     RunResult* result) override;
  TrueEnd End(const std::vector<ProcedureResult>& results, RunResult* result) override;
  double Figure(const std::string& name, const RunResult& result) override;

  ProcedureResult CutPower(const PowerCut& cut);

 private:
  /// `together`: what the same step told.
  std::optional<double> BuiltOf(const std::string& name,
                                const std::vector<Estimate>& together) const;

  MotorStageScenario motor_;
  std::filesystem::path file_;
  Chance chance_;
  MotorStageRig rig_;
  Flash flash_{};
  MotorStageOptions factory_;
  std::unique_ptr<MotorStageFirmware> firmware_;
  double earlier_s_ = 0;  // Machine time before the power was last cut.
  EmulatedLink wire_;
  MotorStageGauge gauge_;
  NoHands hands_{};
  Bench bench_{};
  /// Of the procedures: counts of all, of the others the last.
  std::map<std::string, double> figures_;
  std::size_t history_ = 0;
  std::vector<ParameterResult> told_{};  ///< Beside what was built at that moment.
};

}  // namespace caltwin
