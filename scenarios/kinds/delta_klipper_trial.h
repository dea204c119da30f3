#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scenarios/kinds/delta_scenario.h"
#include "scenarios/kinds/delta_verdict.h"
#include "scenarios/klipper/klipper_trial.h"
#include "sim/base/rng.h"
#include "sim/kinds/delta/calliper.h"

namespace caltwin {

/// @name What a person does at a delta: DeltaKlipperTrial::PersonDoes
inline constexpr std::string_view kFeelerGauge = "feeler_gauge",
                                  kPaperTest = "paper_test",
                                  kMeasuredPrint = "measured_print";

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
  /// `feeler_gauge`: answers the dialogue for the height of the nozzle by TESTZ, until
  /// a gauge of 0.1 mm fits under it, felt to 10 um (standard deviation), then takes
  /// its thickness off. `paper_test`: leaves it, as most do with a sheet of paper.
  /// `measured_print`: prints Klipper's calibration object as the host now believes,
  /// measures it with a calliper and types what it reads (DELTA_ANALYZE).
  Expected<std::vector<std::string>> PersonDoes(std::string_view act) override;

 private:
  Expected<std::vector<std::string>> GaugeUnderNozzle(bool is_taken_off);
  /// The nozzle's height over the bed; nullopt: the host is not there, or lost.
  std::optional<double> NozzleOverBed_mm();
  /// What is typed of it; nullopt: the machine does not reach there.
  std::optional<std::vector<std::string>> PrintAsMeasured();

  Machine machine_;
  BuiltDelta built_;
  DeltaTruth truth_;
  SimulatedDeltaCalliper calliper_;
  Rng felt_;
};

/// The machine that the scenario says, its numbers drawn, on a Klipper board.
std::unique_ptr<KindTrial> BeginDeltaUnderKlipper(const DeltaScenario& delta,
                                                  const Scenario& scenario,
                                                  const Chance& chance);

}  // namespace caltwin
