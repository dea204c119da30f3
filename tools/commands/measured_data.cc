#include "tools/commands/measured_data.h"

#include <algorithm>

#include <fmt/format.h>

#include "calibration/diagnosis/plausible.h"
#include "sim/base/input_error.h"
#include "sim/machine/machine_kind.h"
#include "sim/measure/rows.h"

namespace caltwin {
namespace {

constexpr std::size_t kLeastRows = 3;

// The line of the first row a doubt is about; none: of the file.
Place PlaceOf(const Doubt& doubt, const Data& data, const std::string& file) {
  for (const Row& row : data.table.rows) {
    if (!doubt.rows.empty() && row.row == doubt.rows.front()) return row.place;
  }
  return {.file = file, .line = 1};
}

}  // namespace

Data ReadData(const std::string& file) {
  Data data{.table = ReadRows(file), .header = HeaderOf(file)};
  if (data.table.rows.size() < kLeastRows) {
    throw InputError(
        {.file = file},
        fmt::format("{} rows: too few to tell anything from", data.table.rows.size()),
        "a diagnosis takes at least 5; eight positions both ways are a "
        "beginning");
  }
  const auto tell = [&](const std::vector<std::string>& remarks) {
    data.notes.insert(data.notes.end(), remarks.begin(), remarks.end());
  };
  tell(data.table.remarks);
  tell(data.header.remarks);
  tell(Unexplained(data.table, data.header));
  return data;
}

void JudgeData(const std::string& file, const Machine* machine, Data* data) {
  Faults faults;
  for (const Doubt& doubt : Doubts(data->table, data->header, machine)) {
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
