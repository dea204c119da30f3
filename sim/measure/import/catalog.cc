#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/text_file.h"
#include "sim/base/yaml.h"
#include "sim/machine/machine.h"
#include "sim/measure/import/blunders.h"
#include "sim/measure/import/candle_map.h"
#include "sim/measure/import/check.h"
#include "sim/measure/import/cmm_plate.h"
#include "sim/measure/import/console_log.h"
#include "sim/measure/import/drawn_path.h"
#include "sim/measure/import/height_matrix.h"
#include "sim/measure/import/heightmap_xml.h"
#include "sim/measure/import/import.h"
#include "sim/measure/import/iso230_dat.h"
#include "sim/measure/import/kinds/klipper_delta.h"
#include "sim/measure/import/kinds/told_delta.h"
#include "sim/measure/import/klipper_thermal.h"
#include "sim/measure/import/map.h"
#include "sim/measure/import/named_heights.h"
#include "sim/measure/import/plain_table.h"
#include "sim/measure/import/printer_lint.h"
#include "sim/measure/import/recognise.h"
#include "sim/measure/import/rotary_table.h"
#include "sim/measure/import/rrf_config.h"
#include "sim/measure/import/rrf_heightmap.h"
#include "sim/measure/import/screw_table.h"
#include "sim/measure/import/told_stories.h"

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
    Importer{
        "console-log",
        "a terminal log of Klipper, Marlin, RepRapFirmware or grbl: touches, homings",
        ReadConsoleLog,
        /*has_unit=*/true},
    Importer{"probe-accuracy",
             "the same, of PROBE_ACCURACY (Klipper) or M48 (Marlin)",
             ReadConsoleLog,
             /*has_unit=*/true},
    Importer{"marlin-log",
             "the same, of Marlin: G30, G29 V4, G29 T, M48, settings of M503",
             ReadConsoleLog,
             /*has_unit=*/true},
    Importer{"klipper-delta",
             "a delta's printer.cfg with the touches of its saved calibration",
             ReadKlipperDelta,
             /*has_unit=*/true},
    Importer{"klipper-mesh",
             "the meshes that a printer.cfg holds",
             ReadMeshesOfPrinter,
             /*has_unit=*/true},
    Importer{"rrf-config",
             "config.g, config-override.g of RepRapFirmware: a machine file",
             ReadRrfConfig},
    Importer{"rrf-heightmap",
             "heightmap.csv of RepRapFirmware",
             ReadRrfHeightmap,
             /*has_unit=*/true},
    Importer{"xml-heightmap",
             "a height map in XML, as OpenCNCPilot and GRBL-Plotter save it",
             ReadHeightmapXml,
             /*has_unit=*/true},
    Importer{"candle-map",
             "a height map as Candle saves it",
             ReadCandleMap,
             /*has_unit=*/true},
    Importer{"height-matrix",
             "heights as a sheet has them: x across, y down, the places beside them",
             ReadHeightMatrix,
             /*has_unit=*/true},
    Importer{
        "printer-cfg",
        "a Klipper configuration without measurements: what in it contradicts itself",
        ReadPrinterCfg},
    Importer{"marlin-config",
             "the lengths of a square in a Configuration.h of Marlin",
             ReadMarlinConfig,
             /*has_unit=*/true},
    Importer{"named-heights",
             "heights of places that have names: a delta's towers, a bed's corners",
             ReadNamedHeights,
             /*has_unit=*/true},
    Importer{"drawn-path",
             "a program's moves beside the size that was drawn",
             ReadDrawnPath},
    Importer{"rotary-table",
             "a rotary axis: angles told, and how far off in degrees",
             ReadRotaryTable},
    Importer{"screw-table",
             "a compensation table: LinuxCNC .comp, Centroid .tab",
             ReadScrewTable},
    Importer{"table",
             "a table whose headings say what is what; markdown and HTML too",
             ReadPlainTable},
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

// What a text tells that is no table of readings is told; where nothing can be read, a
// blunder in it is an answer.
Imported ReadOrTell(const Importer& importer,
                    const std::string& text,
                    const std::string& name,
                    const ImportOptions& options,
                    const std::vector<FileNote>& blunders) {
  const bool asks_for_answers = options.tells_blunders && options.map.empty();
  if (auto story = asks_for_answers ? ToldStoryIn(text) : std::nullopt) return *story;
  try {
    return importer.read(text, name, options);
  } catch (const InputError&) {
    if (blunders.empty()) throw;
    return {};
  }
}

// A machine that cannot be is no machine; the readings beside it stay.
void CheckMachine(const std::string& name, Imported* imported) {
  if (imported->machine_yaml.empty()) return;
  try {
    Faults faults;
    YamlMap map = ReadYamlText(imported->machine_yaml, name + " as a machine", &faults);
    ReadMachine(&map);
    faults.ThrowIfAny();
  } catch (const InputError& error) {
    if (imported->table.rows.empty()) throw;
    imported->warnings.push_back(fmt::format(
        "the machine that the settings describe cannot be and was left out: {}",
        error.what()));
    imported->machine_yaml.clear();
  }
}

}  // namespace

std::span<const Importer> AllImporters() {
  return kImporters;
}

std::string KindOrFound(const std::string& kind,
                        const std::string& text,
                        const std::string& name) {
  if (!kind.empty()) return std::string(Find(kind).kind);
  return KindOfText(text, name);
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
  // What the lint of a configuration tells is an answer there, and no refusal.
  const bool is_told = kind == "printer-cfg" && !NotesOfPrinterCfg(text, name).empty();
  if (!is_told && !options.tells_blunders) RefuseBlunders(text, name);
  const std::vector<FileNote> blunders = options.tells_blunders && !is_told
                                             ? BlundersIn(text, name)
                                             : std::vector<FileNote>();
  Imported imported = ReadOrTell(importer, text, name, options, blunders);
  imported.notes.insert(imported.notes.begin(), blunders.begin(), blunders.end());
  if (options.tells_blunders && !options.has_machine) TellOfDelta(text, &imported);
  imported.has_unit |= importer.has_unit || !options.unit.empty();
  std::int64_t number = 0;
  for (Row& row : imported.table.rows) row.row = ++number;
  CheckImported(imported.table);
  CheckMachine(name, &imported);
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
