#pragma once

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "scenarios/kinds/delta_scenario.h"
#include "scenarios/linuxcnc/linuxcnc_trial.h"
#include "sim/kinds/delta/plant.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {

/// A delta under LinuxCNC: places on two rings over its bed, at two heights. What its
/// firmware believes is in the INI file: HOME_OFFSET, and L and R of the kinematics.
class DeltaLinuxCncTrial final : public LinuxCncTrial {
 public:
  DeltaLinuxCncTrial(const Machine& machine,
                     BuiltDelta built,
                     std::unique_ptr<Board> board,
                     UnderLinuxCnc asked)
      : LinuxCncTrial(machine, std::move(board), std::move(asked)),
        machine_(machine),
        built_(std::move(built)) {}

 protected:
  double Step_mm() const override {
    return 1 / std::ranges::min(TowerStepsPerMm(machine_));
  }
  std::vector<Stop> Stops() const override;
  Vec3<double> Tip_mm(const Motors& steps) const override;
  std::vector<Vec3<double>> Uncorrected_mm(
      const std::vector<Stop>& stops) const override;

 private:
  Machine machine_;
  BuiltDelta built_;
};

/// The machine that the scenario says, its numbers drawn.
std::unique_ptr<KindTrial> BeginDeltaUnderLinuxCnc(const DeltaScenario& delta,
                                                   const Scenario& scenario,
                                                   const Chance& chance);

}  // namespace caltwin
