#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scenarios/kinds/gantry_scenario.h"
#include "scenarios/klipper/klipper_trial.h"
#include "sim/twin/built.h"

namespace caltwin {

/// The mesh that a host has saved, held against the table as it is.
struct MeshAgainstTable {
  double table_rms_mm = 0;  ///< Of the table's heights, about their mean.
  double error_rms_mm = 0;  ///< Of what the mesh says of them, likewise.
  double error_most_mm = 0;
};

/// A gantry or a CoreXY under Klipper's own host, which measures its table: the mesh
/// that it saves has to say the table's shape to a tenth, or to 10 um.
class GantryKlipperTrial final : public KlipperTrial {
 public:
  GantryKlipperTrial(Built built,
                     std::unique_ptr<Board> board,
                     KlipperHostOptions options)
      : KlipperTrial(built.machine, std::move(board), std::move(options)),
        built_(std::move(built)) {}

  TrueEnd End(const std::vector<ProcedureResult>& results, RunResult* result) override;
  double Figure(const std::string& name, const RunResult& result) override;

 private:
  Built built_;
  std::optional<MeshAgainstTable> mesh_{};
};

std::unique_ptr<KindTrial> BeginGantryUnderKlipper(const Scenario& scenario,
                                                   const Chance& chance);

}  // namespace caltwin
