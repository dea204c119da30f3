#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "scenarios/kinds/gantry_scenario.h"
#include "scenarios/linuxcnc/linuxcnc_trial.h"
#include "sim/kinds/cartesian/stepped.h"
#include "sim/twin/built.h"

namespace caltwin {

/// A gantry under LinuxCNC: nine places along each axis, from either side.
class GantryLinuxCncTrial final : public LinuxCncTrial {
 public:
  /// `plant` belongs to `board`.
  GantryLinuxCncTrial(Built built,
                      bool is_physics,
                      std::uint64_t seed,
                      std::unique_ptr<Board> board,
                      const SteppedGantry* plant,
                      UnderLinuxCnc asked)
      : LinuxCncTrial(built.machine, std::move(board), std::move(asked)),
        built_(std::move(built)),
        is_physics_(is_physics),
        seed_(seed),
        plant_(plant) {}

 protected:
  double Step_mm() const override {
    return 1 / std::ranges::min(built_.machine.settings.steps_per_mm);
  }
  std::vector<Stop> Stops() const override;
  /// With its play, which is where it has come to.
  Vec3<double> Tip_mm(const Motors& /*steps*/) const override {
    return plant_->Tip_mm();
  }
  std::vector<Vec3<double>> Uncorrected_mm(
      const std::vector<Stop>& stops) const override;

 private:
  Built built_;
  bool is_physics_;
  std::uint64_t seed_;
  const SteppedGantry* plant_;
};

std::unique_ptr<KindTrial> BeginGantryUnderLinuxCnc(const Scenario& scenario,
                                                    const Chance& chance);

}  // namespace caltwin
