#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/measure/columns.h"
#include "sim/measure/import/fields.h"
#include "sim/measure/import/map_binding.h"

namespace caltwin {
namespace {

constexpr std::size_t kMostFaults = 1000;

class Mapper {
 public:
  Mapper(const std::string& text, std::string name)
      : name_(std::move(name)), sheet_(ReadSpreadsheet(text, name_)) {}

  Imported Read(const ImportOptions& options) {
    const std::vector<Assignment> map = ParseMap(options.map);
    if (map.empty()) ThrowWithColumns();
    Binding binding = Bind(map, sheet_, name_, options);
    bound_ = std::move(binding.columns);
    imported_.assumed = std::move(binding.assumed);
    for (const CsvRecord& record : sheet_.records) {
      ReadRecord(record);
      if (faults_.size() >= kMostFaults) break;
    }
    faults_.ThrowIfAny();
    for (const Bound& bound : bound_) {
      if (bound.is_from_order) FillSenses(std::get<Component>(bound.column->member));
    }
    Explain(options);
    return std::move(imported_);
  }

 private:
  std::size_t num_columns() const { return sheet_.records.front().size(); }

  [[noreturn]] void ThrowWithColumns() const {
    std::string columns;
    for (std::size_t i = 0; i < num_columns(); ++i) {
      columns += fmt::format("{}{} {}",
                             i == 0 ? "" : ", ",
                             i + 1,
                             sheet_.headings.empty()
                                 ? "(" + sheet_.records.front()[i].text + " ...)"
                                 : "'" + sheet_.headings[i].text + "'");
    }
    throw InputError(
        {.file = name_},
        fmt::format("which column is which? Found: {}", columns),
        "as --map 'cmd_x_mm=1[mm],value_mm=2[um],dir_x=3,campaign:=laser'; a position "
        "instead of a deviation: actual_mm=2[mm]; docs/importers.md");
  }

  void ReadRecord(const CsvRecord& record) {
    Row row{.campaign = "imported", .place = PlaceOf(record.front(), name_)};
    double actual_mm = kUnknown;
    for (const Bound& bound : bound_) {
      if (bound.is_from_order) continue;
      CsvField field = record[std::min(bound.source, record.size() - 1)];
      if (bound.assignment.is_constant) field.text = bound.assignment.source;
      const std::string& target = bound.assignment.target;
      if (target == "kind") {
        ReadKind(field, &row);
      } else if (target == "value_mm") {
        row.value_mm = Required(bound, field);
      } else if (target == "actual_mm") {
        actual_mm = Required(bound, field);
      } else {
        std::visit([&](auto member) { Assign(member, bound, field, &row); },
                   bound.column->member);
      }
    }
    FillNormal(&row);
    if (Known(actual_mm)) {
      for (const double commanded_mm : row.cmd_mm) {
        if (Known(commanded_mm)) row.value_mm = actual_mm - commanded_mm;
      }
    }
    if (std::ranges::none_of(row.cmd_mm, Known)) {
      faults_.Add(row.place, "the commanded position is empty");
    }
    imported_.table.rows.push_back(std::move(row));
  }

  // The single commanded axis where the map names none; a touch faces its approach.
  void FillNormal(Row* row) {
    if (std::ranges::none_of(row->n, Known)) {
      const auto* axis = std::ranges::find_if(row->cmd_mm, Known);
      if (axis == row->cmd_mm.end()) return;
      const auto index = static_cast<std::size_t>(axis - row->cmd_mm.begin());
      const bool is_faced = row->kind == RowKind::kTouch && row->dir[index] == 1;
      row->n[index] = is_faced ? -1 : 1;
    }
    double square = 0;
    for (double& component : row->n) {
      if (!Known(component)) component = 0;
      square += component * component;
    }
    if (std::abs(std::sqrt(square) - 1) < 1e-3) return;
    faults_.Add(row->place,
                fmt::format("(nx, ny, nz) has the length {:.4g}", std::sqrt(square)),
                "it is a unit vector: its length is 1");
  }

  double Required(const Bound& bound, const CsvField& field) {
    if (field.text.empty()) {
      faults_.Add(PlaceOf(field, name_),
                  fmt::format("{} is empty", bound.assignment.target),
                  "leave a row without a reading out of the file");
    }
    return Number(bound, field);
  }

  void ReadKind(const CsvField& field, Row* row) {
    const auto* found = std::ranges::find(kRowKinds, field.text);
    if (found != kRowKinds.end()) {
      row->kind = static_cast<RowKind>(found - kRowKinds.begin());
      return;
    }
    faults_.Add(PlaceOf(field, name_),
                fmt::format("kind = '{}' is not known", field.text),
                fmt::format("it may be: {}", fmt::join(kRowKinds, ", ")));
  }

  double Number(const Bound& bound, const CsvField& field) {
    if (field.text.empty()) return kUnknown;
    const std::string& target = bound.assignment.target;
    std::optional<double> value =
        bound.is_clock ? ClockTime_s(field.text) : NumberOf(field.text, sheet_.decimal);
    if (!value) {
      faults_.Add(PlaceOf(field, name_),
                  fmt::format("{} = '{}' is not {}",
                              target,
                              field.text,
                              bound.is_clock ? "a time" : "a finite number"),
                  bound.is_clock ? "as 2021-06-13 20:05:00 or 20:05:00"
                                 : "an unknown value is an empty field");
      return kUnknown;
    }
    if (bound.unit != nullptr) value = bound.unit->convert(*value);
    if (bound.assignment.is_reversed) value = -*value;
    if (bound.is_clock) value = SinceStart_s(*value);
    const Bounds bounds = bound.column == nullptr ? kAnyNumber : bound.column->bounds;
    if (*value >= bounds.min && *value <= bounds.max) return *value;
    faults_.Add(
        PlaceOf(field, name_),
        fmt::format(
            "{} = {} is outside {} .. {}", target, *value, bounds.min, bounds.max),
        bound.column == nullptr ? "" : std::string(bound.column->hint));
    return kUnknown;
  }

  // A time of day that falls by more than half a day has passed midnight.
  double SinceStart_s(double time_s) {
    constexpr double kDay_s = 86400;
    if (!Known(start_s_)) start_s_ = last_s_ = time_s;
    while (time_s < last_s_ - kDay_s / 2 && time_s + kDay_s < 2 * kDay_s + start_s_) {
      time_s += kDay_s;
    }
    last_s_ = time_s;
    return time_s - start_s_;
  }

  void Assign(double Row::*member,
              const Bound& bound,
              const CsvField& field,
              Row* row) {
    row->*member = Number(bound, field);
  }
  void Assign(Component component,
              const Bound& bound,
              const CsvField& field,
              Row* row) {
    const double value = Number(bound, field);
    (row->*component.numbers)[component.index] = value;
    const bool is_sense = bound.assignment.target.starts_with("dir_");
    if (!is_sense || !Known(value) || value == std::round(value)) return;
    faults_.Add(
        PlaceOf(field, name_),
        fmt::format("{} = {} is not -1, 0 or 1", bound.assignment.target, value),
        std::string(bound.column->hint));
  }
  void Assign(std::optional<std::int64_t> Row::*member,
              const Bound& bound,
              const CsvField& field,
              Row* row) {
    const double value = Number(bound, field);
    if (!Known(value)) return;
    if (value != std::round(value)) {
      faults_.Add(
          PlaceOf(field, name_),
          fmt::format("{} = {} is no whole number", bound.assignment.target, value));
    }
    row->*member = static_cast<std::int64_t>(value);
  }
  void Assign(std::string Row::*member,
              const Bound& /*bound*/,
              const CsvField& field,
              Row* row) {
    row->*member = field.text;
  }

  // The sense of approach is that from the position before. Where the position stays
  // the axis turned beyond it and came back: the sense of the next change, as in ISO
  // 230-2 cycles. The first position: as the next change.
  void FillSenses(const Component& sense) {
    std::vector<Row>& rows = imported_.table.rows;
    const auto change = [&](std::size_t i) {
      const double step_mm =
          rows[i].cmd_mm[sense.index] - rows[i - 1].cmd_mm[sense.index];
      return step_mm > 0 ? 1.0 : step_mm < 0 ? -1.0 : 0.0;
    };
    double next = kUnknown;
    for (std::size_t i = rows.size(); i-- > 0;) {
      const double here = i == 0 ? 0 : change(i);
      if (here == 1 || here == -1) next = here;
      (rows[i].*sense.numbers)[sense.index] = next;
    }
  }

  void Explain(const ImportOptions& options) {
    for (Row& row : imported_.table.rows) {
      if (!options.campaign.empty()) row.campaign = options.campaign;
    }
    const char* separator = sheet_.separator == ';'    ? "semicolons"
                            : sheet_.separator == '\t' ? "tabs"
                            : sheet_.separator == ','  ? "commas"
                                                       : "blanks";
    imported_.recognised = {
        fmt::format("a sheet of {} rows and {} columns, apart by {}, decimal {}",
                    sheet_.records.size(),
                    num_columns(),
                    separator,
                    sheet_.decimal == ',' ? "comma" : "point")};
    std::set<std::size_t> used;
    for (const Bound& bound : bound_) {
      if (bound.assignment.is_constant) continue;
      used.insert(bound.source);
      imported_.recognised.push_back(fmt::format(
          "{} = {}column {}{}{}",
          bound.assignment.target,
          bound.assignment.is_reversed ? "-" : "",
          bound.source + 1,
          sheet_.headings.empty()
              ? ""
              : fmt::format(" '{}'", sheet_.headings[bound.source].text),
          bound.unit == nullptr ? "" : fmt::format(" in {}", bound.unit->name)));
    }
    std::vector<std::string> left;
    for (std::size_t i = 0; i < num_columns(); ++i) {
      if (used.contains(i)) continue;
      left.push_back(sheet_.headings.empty() ? fmt::format("{}", i + 1)
                                             : sheet_.headings[i].text);
    }
    if (!left.empty()) {
      imported_.assumed.push_back(
          fmt::format("not named in the map and left out: {}", fmt::join(left, ", ")));
    }
    imported_.assumed.emplace_back(
        Names(bound_, "actual_mm")
            ? "value = actual - commanded"
            : "the value is actual minus commanded (a touch: reported minus "
              "nominal, along n); a sheet of commanded minus actual needs "
              "value_mm=-COLUMN");
  }

  std::string name_;
  Spreadsheet sheet_;
  Faults faults_;
  std::vector<Bound> bound_;
  Imported imported_;
  double start_s_ = kUnknown;
  double last_s_ = kUnknown;
};

}  // namespace

Imported ReadMapped(const std::string& text,
                    const std::string& name,
                    const ImportOptions& options) {
  return Mapper(text, name).Read(options);
}

}  // namespace caltwin
