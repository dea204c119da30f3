#include "tools/commands/measured_data.h"

#include <algorithm>

#include <fmt/format.h>

#include "calibration/diagnosis/plausible.h"
#include "sim/base/input_error.h"
#include "sim/base/text_file.h"
#include "sim/machine/machine_kind.h"
#include "sim/measure/rows.h"

namespace caltwin {
namespace {

// The line of the first row a doubt is about; none: of the file.
Place PlaceOf(const Doubt& doubt, const Data& data, const std::string& file) {
  for (const Row& row : data.table.rows) {
    if (!doubt.rows.empty() && row.row == doubt.rows.front()) return row.place;
  }
  return {.file = file, .line = 1};
}

void Tell(const std::vector<std::string>& remarks, Data* data) {
  data->notes.insert(data->notes.end(), remarks.begin(), remarks.end());
}

Data ImportedData(const std::string& kind,
                  const std::string& text,
                  const std::string& file,
                  const ImportOptions& options) {
  ImportOptions how = options;
  how.tells_blunders = true;
  Imported imported = ImportText(kind, text, file, how);
  Data data{
      .table = std::move(imported.table),
      .header = std::move(imported.header),
      .imported_as = kind,
      .machine_yaml = std::move(imported.machine_yaml),
      .story = std::move(imported.notes),
      .levelling = std::move(imported.levelling),
      .next_instrument = std::move(imported.next_instrument),
      .next_sentence = std::move(imported.next_sentence),
      .told_kind = std::move(imported.told_kind),
      .has_places = imported.has_places,
      .known = {.has_unit = imported.has_unit, .is_deviation = imported.is_deviation}};
  for (const std::string& found : imported.recognised) {
    data.notes.push_back("read as " + found);
  }
  for (const std::string& assumed : imported.assumed) {
    data.notes.push_back("assumed: " + assumed);
  }
  Tell(imported.warnings, &data);
  return data;
}

}  // namespace

Data ReadData(const std::string& file, const ImportOptions& options) {
  const std::string text = ReadTextFile(file, kLargestData_bytes);
  const std::string kind =
      options.map.empty() ? KindOrFound("", text, file) : std::string("csv");
  if (kind != "rows") return ImportedData(kind, text, file, options);
  Data data{.table = ReadRows(file), .header = HeaderOf(file)};
  data.known.has_unit = !options.unit.empty();
  if (data.table.rows.empty()) {
    throw InputError({.file = file}, "no rows: only a heading stands here");
  }
  Tell(data.table.remarks, &data);
  Tell(data.header.remarks, &data);
  Tell(Unexplained(data.table, data.header), &data);
  return data;
}

void JudgeData(const std::string& file, const Machine* machine, Data* data) {
  Faults faults;
  for (const Doubt& doubt : Doubts(data->table, data->header, machine, data->known)) {
    if (doubt.refuse) {
      faults.Add(PlaceOf(doubt, *data, file), doubt.message, doubt.hint);
    } else if (doubt.kind == "duplicated_rows") {
      data->notes.push_back(doubt.message + " (the copies are left out here)");
      std::erase_if(data->table.rows, [&](const Row& row) {
        return std::ranges::binary_search(doubt.rows, row.row);
      });
    } else {
      data->notes.push_back(
          doubt.hint.empty() ? doubt.message : doubt.message + " (" + doubt.hint + ")");
    }
  }
  faults.ThrowIfAny();
}

void NoteMissingMotors(const Machine& machine, Data* data) {
  const auto missing = std::ranges::count_if(data->table.rows, [](const Row& row) {
    return !std::ranges::all_of(row.motor_mm, Known);
  });
  // What drives in proportion are told the axes say.
  const bool axes_say = machine.kind->drive_map() != nullptr;
  if (missing == 0 || machine.kind->motors().empty() || axes_say) return;
  data->notes.push_back(fmt::format(
      "{} rows do not say all of motor_a_mm, motor_b_mm, motor_c_mm: there {}",
      missing,
      machine.kind->bed_is_on_screws()
          ? "cmd_z_mm says it of all screws alike, and not of one moved alone"
          : "the machine file's settings say what was told"));
}

}  // namespace caltwin
