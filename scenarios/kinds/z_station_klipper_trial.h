#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scenarios/kinds/z_station_scenario.h"
#include "scenarios/klipper/klipper_trial.h"
#include "sim/kinds/z_station/station.h"

namespace caltwin {

/// A nozzle, its switch and its probe under Klipper's own host. At the end the host is
/// told to go to 5 mm over the middle of the bed: the clean nozzle has to stand within
/// 10 um of that over the print surface.
class ZStationKlipperTrial final : public KlipperTrial {
 public:
  ZStationKlipperTrial(const Machine& machine,
                       ZStationTwin twin,
                       std::unique_ptr<Board> board,
                       KlipperHostOptions options,
                       const Chance& chance)
      : KlipperTrial(machine, std::move(board), std::move(options), chance),
        machine_(machine),
        twin_(std::move(twin)) {}

  void Finish(RunResult* result) override;
  void AddParameters(const Expectation& expect,
                     const std::vector<ProcedureResult>& results,
                     RunResult* result) override;
  TrueEnd End(const std::vector<ProcedureResult>& results, RunResult* result) override;
  double Figure(const std::string& name, const RunResult& result) override;

 protected:
  std::optional<double> NozzleOverBed_mm(const Motors& steps) override;

 private:
  Machine machine_;
  ZStationTwin twin_;
  std::optional<double> error_mm_{};  ///< Of the nozzle's height; nullopt: not homed.
};

std::unique_ptr<KindTrial> BeginStationUnderKlipper(const ZStationScenario& z,
                                                    const Scenario& scenario,
                                                    const Chance& chance);

}  // namespace caltwin
