#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calibration/kinds/z_station/catalog.h"
#include "scenarios/kinds/z_station_scenario.h"
#include "scenarios/kinds/z_station_wire.h"
#include "sim/kinds/z_station/record.h"

namespace caltwin {

/// A nozzle, its switch, probe and plate in a trial: Klipper's G-code on one side, what
/// is true of them on the other. The nozzle commanded to 0 has to stand within 10 um of
/// the print surface.
class ZStationTrial : public KindTrial {
 public:
  ZStationTrial(const ZStationScenario& scenario,
                const Machine& machine,
                const Chance& chance);

  Link* wire() override { return &wire_; }
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

  /// What an operator changes of the station.
  void Change(const std::vector<StationSpec>& change);

 private:
  ZStation Drawn() const;
  std::optional<double> ReadGap_mm(const std::string& campaign);
  double Error_mm() const { return ErrorAt_mm(twin_.middle_mm()); }
  double HeightError_mm() const;
  double ErrorAt_mm(const Eigen::Vector2d& at_mm) const;
  double FirstLayer_mm() const;
  double BuiltOf(const std::string& name) const;

  ZStationScenario z_;
  Chance chance_;
  ZStationTwin twin_;
  KlipperZ klipper_;
  ZStationRecord record_;
  EmulatedLink wire_;
  std::optional<ZStationClient> client_{};
  std::optional<StationHands> hands_{};
  Bench bench_{};
  ZStationDesk* desk_ = nullptr;  ///< The bench's.
  std::size_t touched_before_ = 0;
  bool has_stepped_ = false;
  std::optional<double> before_mm_{};    ///< Before anything was calibrated.
  std::vector<ParameterResult> told_{};  ///< Beside what was built at that moment.
};

}  // namespace caltwin
