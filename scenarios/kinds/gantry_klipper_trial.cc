#include "scenarios/kinds/gantry_klipper_trial.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "scenarios/kinds/corners_klipper_trial.h"
#include "scenarios/kinds/gantry_trial.h"
#include "sim/base/units.h"
#include "sim/kinds/cartesian/corners.h"
#include "sim/kinds/cartesian/klipper.h"
#include "sim/measure/import/klipper_mesh.h"
#include "sim/measure/import/printer_cfg.h"

namespace caltwin {
namespace {

// The mesh that the host has saved, the last where there are several; nullopt: none.
std::optional<KlipperMesh> SavedMeshOf(const std::string& config) {
  const auto saved = PrinterCfg(config, "printer.cfg").AllSaved();
  if (std::ranges::find(saved, "points", &PrinterCfg::Saved::key) == saved.end()) {
    return std::nullopt;
  }
  return ReadKlipperBed(config, "printer.cfg").meshes.back();
}

}  // namespace

std::optional<double> GantryKlipperTrial::NozzleOverBed_mm(const Motors& steps) {
  plant_->Follow(InPlant(WiringOf(built_.machine), steps));
  return built_.Clearance(plant_->Tip_mm()).distance_mm;
}

double GantryKlipperTrial::TableHeight_mm(const Eigen::Vector2d& at_mm) const {
  constexpr double kAbove_mm = 5;
  return kAbove_mm -
         built_.Clearance(Vec3<double>(at_mm[0], at_mm[1], kAbove_mm)).distance_mm;
}

std::optional<TrueFigure> GantryKlipperTrial::JudgedMesh(RunResult* result) {
  const auto saved = SavedMeshOf(host()->Config());
  if (!saved) return std::nullopt;
  const auto count = static_cast<Eigen::Index>(saved->points.size());
  Eigen::ArrayXd table(count), errors(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const MeshPoint& point = saved->points[static_cast<std::size_t>(i)];
    table[i] = TableHeight_mm({point.x_mm, point.y_mm});
    errors[i] = point.z_mm - table[i];
  }
  table -= table.mean();
  errors -= errors.mean();
  mesh_ = {.table_rms_mm = std::sqrt(table.square().mean()),
           .error_rms_mm = std::sqrt(errors.square().mean()),
           .error_most_mm = errors.abs().maxCoeff()};
  result->messages.push_back(fmt::format(
      "the saved mesh says the table's shape to {:.1f} um rms ({:.1f} at most); the "
      "table itself is {:.1f} um rms from flat",
      UmFromMm(mesh_->error_rms_mm),
      UmFromMm(mesh_->error_most_mm),
      UmFromMm(mesh_->table_rms_mm)));
  return Flattened(mesh_->table_rms_mm, mesh_->error_rms_mm);
}

TrueEnd GantryKlipperTrial::End(const std::vector<ProcedureResult>& /*results*/,
                                RunResult* result) {
  const auto mesh = JudgedMesh(result);
  if (mesh) return {.figure = mesh};
  result->messages.emplace_back(
      "no mesh was saved: the table is as little known as before");
  return {.told_wrong = true};
}

double GantryKlipperTrial::Figure(const std::string& name,
                                  const RunResult& /*result*/) {
  if (!mesh_) return std::numeric_limits<double>::quiet_NaN();
  if (name == "mesh_error_mm.rms") return mesh_->error_rms_mm;
  if (name == "mesh_error_mm.most") return mesh_->error_most_mm;
  return std::numeric_limits<double>::quiet_NaN();
}

std::unique_ptr<KindTrial> BeginGantryUnderKlipper(const Scenario& scenario,
                                                   const Chance& chance) {
  const TwinConfig config = MakeTwinConfig(
      scenario,
      {.fidelity = chance.fidelity, .seed = chance.seed, .sample = chance.sample});
  Built built = BuiltUnderController(config);
  const Machine& machine = built.machine;
  KlipperHostOptions options = *scenario.klipper;
  if (options.config.empty()) options.config = PrinterCfgOfGantry(machine, "-");
  BoardWithTip board =
      BoardOfGantry(built, config.fidelity == Fidelity::kPhysics, config.seed);
  if (machine.Own<CornersDrawing>() != nullptr) {
    return std::make_unique<CornersKlipperTrial>(
        std::move(built), std::move(board), std::move(options), chance);
  }
  return std::make_unique<GantryKlipperTrial>(
      std::move(built), std::move(board), std::move(options), chance);
}

}  // namespace caltwin
