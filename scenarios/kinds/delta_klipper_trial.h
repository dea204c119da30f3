#pragma once

#include <string>
#include <vector>

#include "scenarios/kinds/delta_scenario.h"
#include "scenarios/kinds/delta_verdict.h"
#include "scenarios/klipper/klipper_trial.h"

namespace caltwin {

/// A delta under Klipper's own host. What the host has saved in its printer.cfg is what
/// its firmware believes: the nozzle's height over its bed has to become a tenth of
/// what it was.
class DeltaKlipperTrial final : public KlipperTrial {
 public:
  DeltaKlipperTrial(const Machine& machine,
                    const BuiltDelta& built,
                    std::unique_ptr<Board> board,
                    KlipperHostOptions options);

  void Finish(RunResult* result) override;
  void AddParameters(const Expectation& expect,
                     const std::vector<ProcedureResult>& results,
                     RunResult* result) override;
  TrueEnd End(const std::vector<ProcedureResult>& results, RunResult* result) override;
  double Figure(const std::string& name, const RunResult& result) override;

 private:
  Machine machine_;
  BuiltDelta built_;
  DeltaTruth truth_;
};

/// The machine that the scenario says, its numbers drawn, on a Klipper board.
std::unique_ptr<KindTrial> BeginDeltaUnderKlipper(const DeltaScenario& delta,
                                                  const Scenario& scenario,
                                                  const Chance& chance);

}  // namespace caltwin
