#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scenarios/kinds/delta_scenario.h"
#include "scenarios/kinds/delta_verdict.h"
#include "scenarios/klipper/klipper_trial.h"
#include "sim/kinds/delta/calliper.h"

namespace caltwin {

/// What a person does at a delta, beside what one does anywhere: prints Klipper's
/// calibration object as the host now believes, measures it with a calliper and types
/// what it reads (DELTA_ANALYZE).
inline constexpr std::string_view kMeasuredPrint = "measured_print";

/// A delta under Klipper's own host. What the host has saved in its printer.cfg is what
/// its firmware believes: the nozzle's height over its bed has to become a tenth of
/// what it was.
class DeltaKlipperTrial final : public KlipperTrial {
 public:
  DeltaKlipperTrial(const Machine& machine,
                    const BuiltDelta& built,
                    std::unique_ptr<Board> board,
                    KlipperHostOptions options,
                    const Chance& chance,
                    double calliper_sigma_mm);

  void Finish(RunResult* result) override;
  void AddParameters(const Expectation& expect,
                     const std::vector<ProcedureResult>& results,
                     RunResult* result) override;
  TrueEnd End(const std::vector<ProcedureResult>& results, RunResult* result) override;
  double Figure(const std::string& name, const RunResult& result) override;

 protected:
  Expected<std::vector<std::string>> PersonDoes(std::string_view act) override;
  std::optional<double> NozzleOverBed_mm(const Motors& steps) override;

 private:
  /// What is typed of it; nullopt: the machine does not reach there.
  std::optional<std::vector<std::string>> PrintAsMeasured();

  Machine machine_;
  BuiltDelta built_;
  DeltaTruth truth_;
  SimulatedDeltaCalliper calliper_;
};

/// The machine that the scenario says, its numbers drawn, on a Klipper board.
std::unique_ptr<KindTrial> BeginDeltaUnderKlipper(const DeltaScenario& delta,
                                                  const Scenario& scenario,
                                                  const Chance& chance);

}  // namespace caltwin
