#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scenarios/kinds/gantry_scenario.h"
#include "scenarios/linuxcnc/linuxcnc_trial.h"
#include "sim/kinds/cartesian/stepped.h"
#include "sim/twin/built.h"

namespace caltwin {

/// How far the tip truly is from where it was sent, at places all along each axis, come
/// to from both sides, about the mean of all. That mean is where the part's zero goes.
struct PlacesReached {
  double zero_shift_mm = 0;
  double rms_mm = 0, p95_mm = 0, most_mm = 0;
};

/// A gantry under LinuxCNC. The figure is the p95 of how far its tip is from where
/// LinuxCNC, with all that it corrects, sends it; before: where a controller would
/// bring it that knows steps/mm alone, as `settings` has them. It has to fall to a
/// tenth, or to 2 um: whole steps, and switches seen once a servo cycle.
class GantryLinuxCncTrial final : public LinuxCncTrial {
 public:
  /// `plant` belongs to `board`.
  GantryLinuxCncTrial(Built built,
                      std::uint64_t seed,
                      std::unique_ptr<Board> board,
                      const SteppedGantry* plant,
                      UnderLinuxCnc asked);

  void Finish(RunResult* result) override;
  void AddParameters(const Expectation& /*expect*/,
                     const std::vector<ProcedureResult>& /*results*/,
                     RunResult* /*result*/) override {}
  TrueEnd End(const std::vector<ProcedureResult>& results, RunResult* result) override;
  double Figure(const std::string& name, const RunResult& result) override;

 private:
  PlacesReached ReachedBefore() const;
  std::optional<PlacesReached> ReachedAfter();

  Built built_;
  std::uint64_t seed_;
  const SteppedGantry* plant_;
  std::optional<PlacesReached> before_{}, after_{};
};

std::unique_ptr<KindTrial> BeginGantryUnderLinuxCnc(const Scenario& scenario,
                                                    const Chance& chance);

}  // namespace caltwin
