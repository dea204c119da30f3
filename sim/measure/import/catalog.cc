#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/text_file.h"
#include "sim/measure/import/blunders.h"
#include "sim/measure/import/check.h"
#include "sim/measure/import/cmm_plate.h"
#include "sim/measure/import/import.h"
#include "sim/measure/import/iso230_dat.h"
#include "sim/measure/import/kinds/klipper_delta.h"
#include "sim/measure/import/klipper_mesh.h"
#include "sim/measure/import/klipper_thermal.h"
#include "sim/measure/import/map.h"
#include "sim/measure/import/marlin_log.h"
#include "sim/measure/import/probe_accuracy.h"
#include "sim/measure/import/rrf_config.h"
#include "sim/measure/import/rrf_heightmap.h"

namespace caltwin {
namespace {

constexpr std::array kImporters = {
    Importer{"iso230-dat",
             "a positioning test: ecmc *_ISO230.dat, Renishaw .rtl, a sheet of runs",
             ReadIso230Dat},
    Importer{
        "klipper-thermal",
        "trigger height against temperature: frame expansion CSV, probe drift JSON",
        ReadKlipperThermal},
    Importer{"cmm-plate",
             "holes of a plate, nominal and measured on a coordinate measuring machine",
             ReadCmmPlate},
    Importer{"probe-accuracy",
             "a terminal log of PROBE_ACCURACY (Klipper) or M48 (Marlin)",
             ReadProbeAccuracy},
    Importer{
        "marlin-log",
        "a terminal log of Marlin: touches of G30, G29 V4 and M48, settings of M503",
        ReadMarlinLog},
    Importer{"klipper-delta",
             "a delta's printer.cfg with the touches of its saved calibration",
             ReadKlipperDelta},
    Importer{"klipper-mesh", "the meshes that a printer.cfg holds", ReadKlipperMesh},
    Importer{"rrf-config",
             "config.g, config-override.g of a delta (M665 M666): a machine file",
             ReadRrfConfig},
    Importer{"rrf-heightmap", "heightmap.csv of RepRapFirmware", ReadRrfHeightmap},
    Importer{"csv", "a spreadsheet, its columns named by --map", ReadMapped}};

const Importer& Find(const std::string& kind) {
  std::vector<std::string> kinds;
  for (const Importer& importer : kImporters) {
    if (importer.kind == kind) return importer;
    kinds.emplace_back(importer.kind);
  }
  const std::string nearest = NearestWord(kind, kinds);
  throw InputError(
      {},
      fmt::format("caltwin import: the kind '{}' is not known", kind),
      (nearest.empty() ? "" : fmt::format("did you mean '{}'? ", nearest)) +
          fmt::format("It may be: {}", fmt::join(kinds, ", ")));
}

}  // namespace

std::span<const Importer> AllImporters() {
  return kImporters;
}

Imported Import(const std::string& kind,
                const std::filesystem::path& file,
                const ImportOptions& options) {
  Find(kind);  // A misspelt kind is told before a missing file.
  return ImportText(
      kind, ReadTextFile(file, kLargestData_bytes), file.string(), options);
}

Imported ImportText(const std::string& kind,
                    const std::string& text,
                    const std::string& name,
                    const ImportOptions& options) {
  const Importer& importer = Find(kind);
  RequireText(text, name);
  RefuseBlunders(text, name);
  Imported imported = importer.read(text, name, options);
  std::int64_t number = 0;
  for (Row& row : imported.table.rows) row.row = ++number;
  CheckImported(imported.table);
  imported.table.comments.insert(
      imported.table.comments.begin(),
      fmt::format("Read from {} by caltwin import {}",
                  std::filesystem::path(name).filename().string(),
                  kind));
  for (std::string& comment : imported.table.comments) {
    std::ranges::replace_if(
        comment, [](char c) { return c >= 0 && c < ' '; }, ' ');
    comment.erase(comment.find_last_not_of(' ') + 1);
    comment.erase(0, comment.find_first_not_of(' '));
  }
  return imported;
}

}  // namespace caltwin
