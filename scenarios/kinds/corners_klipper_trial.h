#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "scenarios/klipper/klipper_trial.h"
#include "sim/twin/built.h"

namespace caltwin {

/// A gantry on four motors of Z under Klipper's own host, which levels it by
/// QUAD_GANTRY_LEVEL: over its table it has to hang a tenth as uneven as when it was
/// switched on, or even to 10 um.
class CornersKlipperTrial final : public KlipperTrial {
 public:
  CornersKlipperTrial(Built built,
                      std::unique_ptr<Board> board,
                      KlipperHostOptions options)
      : KlipperTrial(built.machine, std::move(board), std::move(options)),
        built_(std::move(built)) {}

  void Finish(RunResult* result) override;
  TrueEnd End(const std::vector<ProcedureResult>& results, RunResult* result) override;
  double Figure(const std::string& name, const RunResult& result) override;

 private:
  Built built_;
  double before_mm_ = 0, after_mm_ = 0;
};

}  // namespace caltwin
