#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scenarios/kinds/gantry_scenario.h"
#include "scenarios/klipper/klipper_trial.h"
#include "sim/kinds/cartesian/corners.h"
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
class GantryKlipperTrial : public KlipperTrial {
 public:
  GantryKlipperTrial(Built built,
                     BoardWithTip board,
                     KlipperHostOptions options,
                     const Chance& chance)
      : KlipperTrial(built.machine, std::move(board.board), std::move(options), chance),
        built_(std::move(built)),
        plant_(board.plant) {}

  TrueEnd End(const std::vector<ProcedureResult>& results, RunResult* result) override;
  double Figure(const std::string& name, const RunResult& result) override;

 protected:
  const Built& built() const { return built_; }
  std::optional<double> NozzleOverBed_mm(const Motors& steps) override;
  /// How high the table stands there, as the gantry sees it.
  virtual double TableHeight_mm(const Eigen::Vector2d& at_mm) const;
  /// What the mesh says that was saved last, told as a message; nullopt: none was.
  std::optional<TrueFigure> JudgedMesh(RunResult* result);

 private:
  Built built_;
  SteppedTip* plant_;  ///< Its board's.
  std::optional<MeshAgainstTable> mesh_{};
};

std::unique_ptr<KindTrial> BeginGantryUnderKlipper(const Scenario& scenario,
                                                   const Chance& chance);

}  // namespace caltwin
