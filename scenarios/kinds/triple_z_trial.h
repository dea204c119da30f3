#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scenarios/kinds/nobody.h"
#include "scenarios/kinds/triple_z_scenario.h"
#include "scenarios/kinds/triple_z_wire.h"
#include "sim/kinds/triple_z/record.h"

namespace caltwin {

/// A link whose lines the engine's idea of the printer hears too.
class HeardByPrinter : public Link {
 public:
  /// Both are borrowed.
  HeardByPrinter(Link* link, TripleZPrinter* printer)
      : link_(link), printer_(printer) {}
  Expected<std::vector<std::string>> Send(std::string_view line,
                                          std::chrono::milliseconds patience) override;

 private:
  Link* link_;
  TripleZPrinter* printer_;
};

/// A triple-Z printer in a trial: the procedures speak RepRapFirmware's G-code to the
/// twin and see nothing else of it. Where something levelled, the bed has to be a tenth
/// as tilted as before (or flat to 10 um) and within the published 0.1 mm of its
/// reference.
class TripleZTrial : public KindTrial {
 public:
  TripleZTrial(const TripleZScenario& scenario,
               const Machine& machine,
               const Chance& chance);

  Link* wire() override { return &wire_; }
  void Connect(Link* link) override;
  Bench* bench() override { return &bench_; }
  void Before(RunResult* result) override;
  void BeginStep(const CalibrationStep& step) override;
  void EndStep(const CalibrationStep& step, ProcedureResult* done) override;
  void EndExternal(ProcedureResult* done) override;
  void Finish(RunResult* result) override;
  void AddParameters(const Expectation& expect,
                     const std::vector<ProcedureResult>& results,
                     RunResult* result) override;
  TrueEnd End(const std::vector<ProcedureResult>& results, RunResult* result) override;
  double Figure(const std::string& name, const RunResult& result) override;

 private:
  double BuiltOf(const std::string& name) const;
  TrueLevel LevelNow() const;

  TripleZScenario triple_z_;
  BuiltTripleZ built_;
  TripleZTwinPlant plant_;
  Firmware firmware_;
  EmulatedLink wire_;
  TripleZRecord record_;
  NoGauges gauges_{};
  NoHands hands_{};
  Bench bench_{};
  TripleZPrinter* printer_ = nullptr;  ///< The bench's.
  std::optional<HeardByPrinter> heard_{};
  TrueLevel was_{};
  std::vector<Estimate> estimates_{};
  std::size_t touched_before_ = 0;
  std::map<std::string, double> figures_{};  ///< Of the procedures, the last of each.
  int grew_ = 0;
  bool has_levelled_ = false;
};

}  // namespace caltwin
