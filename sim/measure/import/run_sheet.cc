#include <algorithm>
#include <map>

#include <fmt/format.h>

#include "sim/measure/import/fields.h"
#include "sim/measure/import/positioning.h"
#include "sim/measure/import/unit.h"

namespace caltwin {
namespace {

constexpr const char* kForm =
    "a sheet has a header line (target, fwd1, bwd1, fwd2, ...), then a line a target; "
    "columns apart by blanks, tabs, commas or semicolons. Anything else: caltwin "
    "import "
    "csv FILE --map ...";

/// A column of deviations: a run in one sense.
struct RunColumn {
  int run = 0;
  double sense = 0;
};

/// 1 forward, -1 backward, 0: the heading does not say.
double SenseIn(const std::string& heading) {
  const std::string word = PlainWord(heading);
  for (const std::string_view forward : {"fwd", "forward", "up", "+"}) {
    if (word.starts_with(forward)) return 1;
  }
  for (const std::string_view backward :
       {"bwd", "backward", "rev", "down", "-", "return"}) {
    if (word.starts_with(backward)) return -1;
  }
  return 0;
}

/// The lines of the sheet, whatever separates the columns. A decimal comma goes with a
/// semicolon, a tab or blanks, never with a comma.
std::vector<CsvRecord> RecordsOf(const std::string& text,
                                 const std::string& name,
                                 Faults* faults) {
  std::vector<CsvRecord> records;
  for (const char separator : {';', '\t', ','}) {
    if (text.substr(0, text.find('\n')).find(separator) == std::string::npos) continue;
    CsvReader csv(text, name, faults, separator);
    while (auto record = csv.Next()) records.push_back(std::move(*record));
    return records;
  }
  for (TextLine& line : LinesOf(text)) {
    if (!line.text.starts_with('#')) records.push_back(std::move(line.words));
  }
  return records;
}

std::vector<RunColumn> ColumnsOf(const CsvRecord& header, const std::string& name) {
  std::vector<RunColumn> columns;
  std::map<double, int> num_runs;
  Faults faults;
  for (std::size_t i = 1; i < header.size(); ++i) {
    const double sense = SenseIn(header[i].text);
    if (sense == 0) {
      faults.Add(
          PlaceOf(header[i], name),
          fmt::format("the heading '{}' does not say in which sense the run went",
                      header[i].text),
          "it begins with fwd, forward, up, + or bwd, backward, rev, down, -");
    }
    columns.push_back({.run = ++num_runs[sense], .sense = sense});
  }
  faults.ThrowIfAny();
  return columns;
}

const NamedUnit& UnitOf(const CsvRecord& header,
                        const std::string& name,
                        const ImportOptions& options) {
  if (!options.unit.empty()) {
    return FindUnit(options.unit, Quantity::kLength, {.file = "--unit"});
  }
  for (std::size_t i = 1; i < header.size(); ++i) {
    if (const NamedUnit* unit = UnitInHeading(header[i].text, Quantity::kLength)) {
      return *unit;
    }
  }
  throw InputError(PlaceOf(header[1], name),
                   "nothing says the unit of the deviations",
                   "say it: --unit um, or in the heading: fwd1_um, 'fwd 1 [um]'");
}

}  // namespace

Imported ReadRunSheet(const std::string& text,
                      const std::string& name,
                      const ImportOptions& options) {
  Faults faults;
  const std::vector<CsvRecord> records = RecordsOf(text, name, &faults);
  faults.ThrowIfAny();
  if (records.size() < 2 || records.front().size() < 2 ||
      NumberOf(records.front().front().text)) {
    throw InputError({.file = name, .line = 1, .column = 1},
                     "this is no positioning test in a form that is known",
                     kForm);
  }
  const CsvRecord& header = records.front();
  const std::vector<RunColumn> columns = ColumnsOf(header, name);
  const NamedUnit& unit = UnitOf(header, name, options);
  std::map<std::pair<int, double>, std::vector<PositionReading>> by_run;
  for (std::size_t line = 1; line < records.size(); ++line) {
    const CsvRecord& record = records[line];
    if (record.size() != header.size()) {
      faults.Add(PlaceOf(record.front(), name),
                 fmt::format("{} fields, where the header names {} columns",
                             record.size(),
                             header.size()));
      continue;
    }
    const double target_mm = NumberIn(record[0], "the target", name, &faults);
    for (std::size_t i = 1; i < record.size(); ++i) {
      if (record[i].text.empty()) continue;
      const RunColumn& column = columns[i - 1];
      by_run[{column.run, -column.sense}].push_back(
          {.run = column.run,
           .sense = column.sense,
           .target_mm = target_mm,
           .value_mm = unit.convert(NumberIn(record[i], "a deviation", name, &faults)),
           .place = PlaceOf(record[i], name)});
    }
  }
  faults.ThrowIfAny();
  std::vector<PositionReading> readings;
  for (auto& [run, column] : by_run) {
    if (run.second > 0) std::reverse(column.begin(), column.end());
    readings.insert(readings.end(), column.begin(), column.end());
  }
  if (readings.empty()) {
    throw InputError(PlaceOf(header[1], name), "no readings stand here", kForm);
  }
  std::vector<std::string> assumed = {
      "targets are in mm; a deviation is actual minus commanded",
      "targets are listed in the sense of the forward runs; a backward run was "
      "measured "
      "from the last to the first"};
  const std::string axis = AxisOr("", options, &assumed);
  Imported imported = PositioningRows(readings, axis, options);
  imported.assumed = std::move(assumed);
  imported.recognised = {
      fmt::format("a sheet of {} targets and {} runs, deviations in {}",
                  records.size() - 1,
                  by_run.size(),
                  unit.name)};
  return imported;
}

}  // namespace caltwin
