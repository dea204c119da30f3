#include "sim/measure/import/klipper_mesh.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include "sim/machine/kinds/delta/model.h"
#include "sim/measure/import/fields.h"

namespace caltwin {
namespace {

constexpr double kMostCount = 100;
constexpr double kFarthest_mm = 10'000;

/// The whole square, copies included.
struct Square {
  std::array<double, 2> min_mm{}, max_mm{};
  std::vector<std::vector<double>> rows{};  ///< By y, then x.
  std::vector<CsvField> lines{};

  int count(int axis) const {
    return static_cast<int>(axis == 0 ? rows.front().size() : rows.size());
  }
  double At_mm(int axis, int index) const {
    const auto i = static_cast<std::size_t>(axis);
    return min_mm[i] + (max_mm[i] - min_mm[i]) * index / (count(axis) - 1);
  }
};

void ReadLimits(const PrinterCfg& cfg,
                const std::string& section,
                Square* square,
                Faults* faults) {
  for (std::size_t i = 0; i < 2; ++i) {
    const char letter = "xy"[i];
    for (const bool is_min : {true, false}) {
      const std::string key = fmt::format("{}_{}", is_min ? "min" : "max", letter);
      const auto limit = cfg.Number(section, key, -kFarthest_mm, kFarthest_mm, faults);
      if (!limit && cfg.Find(section, key) == nullptr) {
        faults->Add(cfg.PlaceOfSection(section),
                    fmt::format("[{}] {} is not stated", section, key),
                    "without it nobody knows where the points lie");
      }
      (is_min ? square->min_mm : square->max_mm)[i] = limit.value_or(0);
    }
    if (faults->empty() && square->max_mm[i] - square->min_mm[i] < 1) {
      faults->Add(
          cfg.PlaceOfSection(section),
          fmt::format("[{}] is less than a millimetre wide along {}", section, letter));
    }
  }
}

void ReadPoints(const PrinterCfg& cfg,
                const std::string& section,
                Square* square,
                Faults* faults) {
  const CfgSetting& points = *cfg.Find(section, "points");
  std::vector<CsvField> lines = points.more;
  if (!points.value.text.empty()) lines.insert(lines.begin(), points.value);
  const auto x_count = cfg.Number(section, "x_count", 2, kMostCount, faults);
  const auto y_count = cfg.Number(section, "y_count", 2, kMostCount, faults);
  if (!x_count || !y_count) {
    if (faults->empty()) {
      faults->Add(cfg.PlaceOfSection(section),
                  fmt::format("[{}] x_count or y_count is not stated", section));
    }
    return;
  }
  if (static_cast<double>(lines.size()) != *y_count) {
    faults->Add(PlaceOf(points.value, cfg.name()),
                fmt::format("[{}] has {} lines of points, y_count is {:g}",
                            section,
                            lines.size(),
                            *y_count));
    return;
  }
  for (const CsvField& line : lines) {
    square->rows.push_back(
        NumbersIn(line, fmt::format("[{}] points", section), cfg.name(), faults));
    if (static_cast<double>(square->rows.back().size()) != *x_count) {
      faults->Add(PlaceOf(line, cfg.name()),
                  fmt::format("[{}] this line has {} points, x_count is {:g}",
                              section,
                              square->rows.back().size(),
                              *x_count));
    }
  }
  square->lines = std::move(lines);
}

/// Radius of the circle through the middles of the sides; unknown of what is no square.
double RadiusOf(const Square& square) {
  constexpr double kRounding_mm = 0.1;  // SAVE_CONFIG writes -74.99 for -75.
  const double x_mm = (square.max_mm[0] - square.min_mm[0]) / 2;
  const double y_mm = (square.max_mm[1] - square.min_mm[1]) / 2;
  return std::abs(x_mm - y_mm) < kRounding_mm ? std::max(x_mm, y_mm) + kRounding_mm
                                              : kUnknown;
}

bool IsBeyond(const Square& square, int x, int y, double radius_mm) {
  const double dx = square.At_mm(0, x) - (square.min_mm[0] + square.max_mm[0]) / 2;
  const double dy = square.At_mm(1, y) - (square.min_mm[1] + square.max_mm[1]) / 2;
  return std::hypot(dx, dy) > radius_mm;
}

/// Whether every point beyond the circle repeats the outermost of its row within.
bool IsRound(const Square& square, double radius_mm) {
  if (!Known(radius_mm)) return false;
  bool is_any_beyond = false;
  for (int y = 0; y < square.count(1); ++y) {
    const std::vector<double>& row = square.rows[static_cast<std::size_t>(y)];
    const int last = square.count(0) - 1;
    int first_in = 0, last_in = last;
    while (first_in <= last && IsBeyond(square, first_in, y, radius_mm)) ++first_in;
    while (last_in >= 0 && IsBeyond(square, last_in, y, radius_mm)) --last_in;
    if (first_in > last_in) return false;  // An even count: no point at the rim.
    const auto value = [&](int x) {
      return row[static_cast<std::size_t>(x)];
    };
    for (int x = 0; x <= last; ++x) {
      const int nearest = std::clamp(x, first_in, last_in);
      is_any_beyond |= nearest != x;
      if (value(x) != value(nearest)) return false;
    }
  }
  return is_any_beyond;
}

KlipperMesh MeshOf(const Square& square, const std::string& name, const Place& file) {
  KlipperMesh mesh{
      .name = name, .x_count = square.count(0), .y_count = square.count(1)};
  const double radius_mm = RadiusOf(square);
  mesh.is_round = IsRound(square, radius_mm);
  if (mesh.is_round) mesh.radius_mm = (square.max_mm[0] - square.min_mm[0]) / 2;
  for (int y = 0; y < mesh.y_count; ++y) {
    const auto row = static_cast<std::size_t>(y);
    for (int x = 0; x < mesh.x_count; ++x) {
      if (mesh.is_round && IsBeyond(square, x, y, radius_mm)) {
        ++mesh.num_copies;
        continue;
      }
      mesh.points.push_back({.x_mm = square.At_mm(0, x),
                             .y_mm = square.At_mm(1, y),
                             .z_mm = square.rows[row][static_cast<std::size_t>(x)],
                             .place = PlaceOf(square.lines[row], file.file)});
    }
  }
  return mesh;
}

void WarnOfCorners(const PrinterCfg& cfg, KlipperBed* bed) {
  if (cfg.Find("bed_mesh", "mesh_radius") == nullptr) return;
  for (const KlipperMesh& mesh : bed->meshes) {
    if (mesh.is_round) continue;
    bed->warnings.push_back(fmt::format(
        "mesh '{}': [bed_mesh] has a mesh_radius, but the corners are no copies: all "
        "points are kept, some may never have been probed",
        mesh.name));
  }
}

Row RowOf(const MeshPoint& point, const std::optional<KlipperGeometry>& geometry) {
  Row row{.kind = RowKind::kTouch, .setup = "bed", .place = point.place};
  row.cmd_mm = {point.x_mm, point.y_mm, 0};
  if (geometry) {
    const Vec3<double> motors_mm =
        DeltaMotors_mm<double>(geometry->model, {point.x_mm, point.y_mm, 0});
    row.motor_mm = {motors_mm[0], motors_mm[1], motors_mm[2]};
    row.settings = "saved";
  }
  row.dir[2] = -1;
  row.n = {0, 0, 1};
  row.feature = "bed.top";
  row.value_mm = point.z_mm;
  return row;
}

std::string CampaignOf(const KlipperMesh& mesh) {
  std::string name = "mesh_" + mesh.name;
  std::ranges::replace_if(
      name, [](char c) { return c == ' ' || c == '\t' || c == ','; }, '_');
  return name;
}

}  // namespace

KlipperBed ReadKlipperBed(const std::string& text, const std::string& name) {
  const PrinterCfg cfg(text, name);
  KlipperBed bed;
  Faults faults;
  for (const std::string& section : cfg.Sections("bed_mesh")) {
    if (cfg.Find(section, "points") == nullptr) continue;
    Faults of_this;
    Square square;
    ReadLimits(cfg, section, &square, &of_this);
    ReadPoints(cfg, section, &square, &of_this);
    of_this.ThrowIfAny();
    const std::size_t blank = section.find(' ');
    bed.meshes.push_back(
        MeshOf(square,
               blank == std::string::npos ? section : section.substr(blank + 1),
               {.file = name}));
  }
  if (bed.meshes.empty()) {
    throw InputError({.file = name, .line = 1, .column = 1},
                     "no mesh stands here",
                     "it is the block that SAVE_CONFIG writes after "
                     "BED_MESH_CALIBRATE: #*# [bed_mesh default] with points");
  }
  const CfgSetting* kinematics = cfg.Find("printer", "kinematics");
  if (kinematics != nullptr && kinematics->value.text == "delta") {
    Faults unknown;  // A mesh is a mesh, geometry or not.
    bed.geometry = ReadKlipperGeometry(cfg, std::nullopt, &unknown);
    if (!bed.geometry) {
      bed.warnings.emplace_back(
          "the delta's geometry does not stand in the file: no motor columns");
    }
  }
  WarnOfCorners(cfg, &bed);
  return bed;
}

Imported ReadKlipperMesh(const std::string& text,
                         const std::string& name,
                         const ImportOptions& options) {
  const KlipperBed bed = ReadKlipperBed(text, name);
  Imported imported;
  for (const KlipperMesh& mesh : bed.meshes) {
    const std::string campaign = options.campaign + CampaignOf(mesh);
    for (const MeshPoint& point : mesh.points) {
      Row row = RowOf(point, bed.geometry);
      row.campaign = campaign;
      const bool is_reached =
          std::ranges::all_of(row.motor_mm, [](double q) { return std::isfinite(q); });
      if (!is_reached) row.motor_mm.fill(kUnknown);
      imported.table.rows.push_back(std::move(row));
    }
    imported.recognised.push_back(fmt::format(
        "mesh '{}', {} x {}: {} points{}",
        mesh.name,
        mesh.x_count,
        mesh.y_count,
        mesh.points.size(),
        mesh.is_round ? fmt::format(" within {:g} mm; {} beyond it are copies of "
                                    "their neighbours, left out",
                                    mesh.radius_mm,
                                    mesh.num_copies)
                      : ""));
  }
  imported.warnings = bed.warnings;
  imported.assumed = {
      "the points go row by row from min to max, x first; a value is the bed's height "
      "as "
      "the firmware believed it, + is up"};
  if (bed.geometry) {
    imported.assumed.emplace_back(
        "the mesh was probed under the geometry saved in the same file");
    imported.machine_yaml =
        DeltaMachineYaml({.source = std::filesystem::path(name).filename().string(),
                          .name = MachineNameOf(name),
                          .model = bed.geometry->model,
                          .drive = bed.geometry->drive,
                          .print_radius_mm = bed.geometry->print_radius_mm});
  }
  return imported;
}

}  // namespace caltwin
