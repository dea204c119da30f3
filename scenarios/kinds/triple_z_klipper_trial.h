#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scenarios/kinds/triple_z_scenario.h"
#include "scenarios/kinds/triple_z_wire.h"
#include "scenarios/klipper/klipper_trial.h"

namespace caltwin {

/// A bed on three screws under Klipper's own host. Where its screws stand at the end
/// says how flat it lies: it has to be a tenth as tilted as it was built, or flat to
/// 10 um. Its height is not judged: the host takes it from its own endstop.
class TripleZKlipperTrial final : public KlipperTrial {
 public:
  TripleZKlipperTrial(const BuiltTripleZ& built,
                      std::unique_ptr<Board> board,
                      KlipperHostOptions options,
                      const Chance& chance);

  void Finish(RunResult* result) override;
  TrueEnd End(const std::vector<ProcedureResult>& results, RunResult* result) override;
  double Figure(const std::string& name, const RunResult& result) override;

 protected:
  std::optional<double> NozzleOverBed_mm(const Motors& steps) override;

 private:
  BuiltTripleZ built_;
  Vec3<double> raised_mm_ = Vec3<double>::Zero();
  double flat_before_mm_ = 0;
};

std::unique_ptr<KindTrial> BeginTripleZUnderKlipper(const TripleZScenario& triple_z,
                                                    const Scenario& scenario,
                                                    const Chance& chance);

}  // namespace caltwin
