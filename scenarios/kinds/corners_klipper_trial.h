#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "scenarios/kinds/gantry_klipper_trial.h"
#include "sim/twin/built.h"

namespace caltwin {

/// A gantry on four motors of Z under Klipper's own host, which levels it by
/// QUAD_GANTRY_LEVEL: over its table it has to hang a tenth as uneven as when it was
/// switched on, or even to 10 um. Where a mesh was saved what counts is how far that
/// errs.
class CornersKlipperTrial final : public GantryKlipperTrial {
 public:
  CornersKlipperTrial(Built built,
                      BoardWithTip board,
                      KlipperHostOptions options,
                      const Chance& chance)
      : GantryKlipperTrial(
            std::move(built), std::move(board), std::move(options), chance) {}

  void Finish(RunResult* result) override;
  TrueEnd End(const std::vector<ProcedureResult>& results, RunResult* result) override;
  double Figure(const std::string& name, const RunResult& result) override;

 protected:
  double TableHeight_mm(const Eigen::Vector2d& at_mm) const override;

 private:
  Motors steps_{};  ///< The plant's, at the end.
  double before_mm_ = 0, after_mm_ = 0;
};

}  // namespace caltwin
