#include "scenarios/kinds/gantry_klipper_trial.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <utility>

#include <fmt/format.h>

#include "scenarios/kinds/gantry_trial.h"
#include "sim/base/units.h"
#include "sim/kinds/cartesian/klipper.h"

namespace caltwin {
namespace {

constexpr double kRecovered = 0.1;
constexpr double kFlat_mm = 0.01;

/// A mesh in the part of a printer.cfg that SAVE_CONFIG writes.
struct SavedMesh {
  std::vector<std::vector<double>> heights_mm{};  ///< By row, y upwards.
  Eigen::Vector2d least_mm{0, 0}, most_mm{0, 0};
};

std::vector<std::vector<double>> RowsOf(const std::string& points) {
  std::vector<std::vector<double>> rows;
  std::istringstream lines(points);
  for (std::string line; std::getline(lines, line);) {
    std::ranges::replace(line, ',', ' ');
    std::istringstream numbers(line);
    std::vector<double> row;
    for (double number = 0; numbers >> number;) row.push_back(number);
    if (!row.empty()) rows.push_back(row);
  }
  return rows;
}

std::optional<SavedMesh> SavedMeshOf(const std::string& config) {
  SavedMesh mesh;
  for (const SavedSetting& one : SavedSettingsOf(config)) {
    if (!one.section.starts_with("bed_mesh ")) continue;
    if (one.option == "points") {
      mesh.heights_mm = RowsOf(one.value);
      continue;
    }
    const double value = std::strtod(one.value.c_str(), nullptr);
    if (one.option == "min_x") mesh.least_mm[0] = value;
    if (one.option == "max_x") mesh.most_mm[0] = value;
    if (one.option == "min_y") mesh.least_mm[1] = value;
    if (one.option == "max_y") mesh.most_mm[1] = value;
  }
  const std::size_t columns = mesh.heights_mm.empty() ? 0 : mesh.heights_mm[0].size();
  const bool is_whole = mesh.heights_mm.size() >= 2 && columns >= 2 &&
                        std::ranges::all_of(mesh.heights_mm, [&](const auto& row) {
                          return row.size() == columns;
                        });
  if (!is_whole) return std::nullopt;
  return mesh;
}

double Rms(const std::vector<double>& values) {
  double mean = 0, squares = 0;
  for (const double one : values) mean += one / static_cast<double>(values.size());
  for (const double one : values) squares += (one - mean) * (one - mean);
  return std::sqrt(squares / static_cast<double>(values.size()));
}

// How high a ball stands that rests on the table there.
double TableHeight_mm(const Built& built, double x_mm, double y_mm) {
  constexpr double kAbove_mm = 5;
  return kAbove_mm - built.Clearance(Vec3<double>(x_mm, y_mm, kAbove_mm)).distance_mm;
}

MeshAgainstTable Compared(const SavedMesh& mesh, const Built& built) {
  std::vector<double> table, errors;
  const auto rows = static_cast<double>(mesh.heights_mm.size() - 1);
  const auto columns = static_cast<double>(mesh.heights_mm[0].size() - 1);
  for (std::size_t row = 0; row < mesh.heights_mm.size(); ++row) {
    for (std::size_t column = 0; column < mesh.heights_mm[row].size(); ++column) {
      const Eigen::Vector2d part(static_cast<double>(column) / columns,
                                 static_cast<double>(row) / rows);
      const Eigen::Vector2d at_mm =
          mesh.least_mm + part.cwiseProduct(mesh.most_mm - mesh.least_mm);
      table.push_back(TableHeight_mm(built, at_mm[0], at_mm[1]));
      errors.push_back(mesh.heights_mm[row][column] - table.back());
    }
  }
  MeshAgainstTable result{.table_rms_mm = Rms(table), .error_rms_mm = Rms(errors)};
  double mean = 0;
  for (const double one : errors) mean += one / static_cast<double>(errors.size());
  for (const double one : errors) {
    result.error_most_mm = std::max(result.error_most_mm, std::abs(one - mean));
  }
  return result;
}

}  // namespace

TrueEnd GantryKlipperTrial::End(const std::vector<ProcedureResult>& /*results*/,
                                RunResult* result) {
  const auto saved = SavedMeshOf(host()->Config());
  if (!saved) {
    result->messages.emplace_back(
        "no mesh was saved: the table is as little known as "
        "before");
    return {.told_wrong = true};
  }
  mesh_ = Compared(*saved, built_);
  result->messages.push_back(fmt::format(
      "the saved mesh says the table's shape to {:.1f} um rms ({:.1f} at most); the "
      "table itself is {:.1f} um rms from flat",
      UmFromMm(mesh_->error_rms_mm),
      UmFromMm(mesh_->error_most_mm),
      UmFromMm(mesh_->table_rms_mm)));
  return {.figure = TrueFigure{
              .before = mesh_->table_rms_mm,
              .after = mesh_->error_rms_mm,
              .noise = kFlat_mm,
              .is_met = mesh_->error_rms_mm <=
                        std::max(kRecovered * mesh_->table_rms_mm, kFlat_mm)}};
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
  const auto probe = config.instruments.find("probe");
  const double sigma_mm =
      probe == config.instruments.end() ? 0 : MmFromUm(probe->second.sigma_um);
  Machine machine = config.machine;
  machine.settings = config.settings;
  Built built{
      .machine = machine, .effects = config.effects, .probe_sigma_mm = sigma_mm};
  built.Prepare();
  KlipperHostOptions options = *scenario.klipper;
  if (options.config.empty()) options.config = PrinterCfgOfGantry(machine, "-");
  auto board = std::make_unique<klipper::PlantBoard>(
      WiringOfGantry(machine), std::make_unique<SteppedGantry>(built, config.seed));
  return std::make_unique<GantryKlipperTrial>(
      std::move(built), std::move(board), std::move(options));
}

}  // namespace caltwin
