#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/measure/columns.h"
#include "sim/measure/import/fields.h"
#include "sim/measure/import/map.h"
#include "sim/measure/import/spreadsheet.h"
#include "sim/measure/import/unit.h"

namespace caltwin {
namespace {

constexpr std::size_t kMostFaults = 1000;

Quantity QuantityOf(std::string_view target) {
  if (target.ends_with("_mm")) return Quantity::kLength;
  if (target == "t_s") return Quantity::kTime;
  if (target.starts_with("temp_")) return Quantity::kTemperature;
  return Quantity::kPlain;
}

const Column* ColumnNamed(std::string_view name) {
  for (const Column& column : AllColumns()) {
    if (column.name == name) return &column;
  }
  return nullptr;
}

/// An assignment with everything found: where it reads, and how it converts.
struct Bound {
  Assignment assignment{};
  const Column* column = nullptr;  ///< Null for kind, value_mm and actual_mm.
  std::size_t source = 0;
  const NamedUnit* unit = nullptr;
  bool is_clock = false;
  bool is_from_order = false;
};

class Mapper {
 public:
  Mapper(const std::string& text, std::string name)
      : name_(std::move(name)), sheet_(ReadSpreadsheet(text, name_)) {}

  Imported Read(const ImportOptions& options) {
    const std::vector<Assignment> map = ParseMap(options.map);
    if (map.empty()) ThrowWithColumns();
    Bind(map, options);
    faults_.ThrowIfAny();
    RequireColumns();
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
  std::vector<std::string> Headings() const {
    std::vector<std::string> headings;
    for (const CsvField& field : sheet_.headings) headings.push_back(field.text);
    return headings;
  }

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

  void Bind(const std::vector<Assignment>& map, const ImportOptions& options) {
    std::string value_unit = options.unit;
    for (const Assignment& assignment : map) {
      if (assignment.target == "unit") value_unit = assignment.source;
    }
    for (const Assignment& assignment : map) {
      if (assignment.target == "unit") continue;
      Bound bound{.assignment = assignment, .column = ColumnNamed(assignment.target)};
      const Place place{.file = "--map " + assignment.target};
      if (assignment.is_constant) {
        BindConstant(&bound);
      } else {
        bound.source = SourceOf(assignment, place);
        BindUnit(value_unit, place, &bound);
      }
      bound_.push_back(std::move(bound));
    }
  }

  void BindConstant(Bound* bound) const {
    bound->is_from_order = bound->assignment.target.starts_with("dir_") &&
                           bound->assignment.source == "order";
  }

  std::size_t SourceOf(const Assignment& assignment, const Place& place) {
    std::vector<std::string> found;
    for (std::size_t i = 0; i < sheet_.headings.size(); ++i) {
      const std::string& heading = sheet_.headings[i].text;
      if (heading == assignment.source ||
          PlainWord(heading) == PlainWord(assignment.source)) {
        return i;
      }
    }
    const auto number = NumberOf(assignment.source);
    if (number && *number >= 1 && *number <= static_cast<double>(num_columns()) &&
        *number == std::round(*number)) {
      return static_cast<std::size_t>(*number) - 1;
    }
    const std::string nearest = NearestWord(assignment.source, Headings());
    faults_.Add(
        place,
        fmt::format("{} has no column '{}'", name_, assignment.source),
        (nearest.empty() ? "" : fmt::format("did you mean '{}'? ", nearest)) +
            fmt::format("It has 1 to {}{}",
                        num_columns(),
                        sheet_.headings.empty()
                            ? ""
                            : fmt::format(": {}", fmt::join(Headings(), ", "))));
    return 0;
  }

  // The unit behind the source wins over the heading's; lengths along an axis without
  // either are taken as mm and said so, a value's unit is never guessed.
  void BindUnit(const std::string& value_unit, const Place& place, Bound* bound) {
    const Assignment& assignment = bound->assignment;
    const Quantity quantity = QuantityOf(assignment.target);
    if (quantity == Quantity::kPlain) return;
    if (assignment.unit == "clock" && quantity == Quantity::kTime) {
      bound->is_clock = true;
      return;
    }
    const bool is_value =
        assignment.target == "value_mm" || assignment.target == "actual_mm";
    const NamedUnit* in_heading =
        sheet_.headings.empty()
            ? nullptr
            : UnitInHeading(sheet_.headings[bound->source].text, quantity);
    std::string stated = assignment.unit;
    if (stated.empty() && is_value) stated = value_unit;
    if (!stated.empty()) {
      bound->unit = &FindUnit(stated, quantity, place);
      if (in_heading == nullptr || in_heading->name == bound->unit->name) return;
      faults_.Add(
          PlaceOf(sheet_.headings[bound->source], name_),
          fmt::format(
              "the heading says {}, the map {}", in_heading->name, bound->unit->name),
          "one of them is wrong: correct the heading or the map");
    } else if (in_heading != nullptr) {
      bound->unit = in_heading;
      imported_.assumed.push_back(fmt::format(
          "{} is in {}, as its heading says", assignment.target, in_heading->name));
    } else if (is_value) {
      faults_.Add(place,
                  "nothing says its unit",
                  fmt::format("say it: {}={}[um] or [mm], [inch], [thou]",
                              assignment.target,
                              assignment.source));
    } else {
      const char* usual = quantity == Quantity::kLength ? "mm"
                          : quantity == Quantity::kTime ? "s"
                                                        : "C";
      bound->unit = &FindUnit(usual, quantity, place);
      imported_.assumed.push_back(
          fmt::format("{} is in {}: nothing says so", assignment.target, usual));
    }
  }

  bool Has(std::string_view target) const {
    return std::ranges::any_of(
        bound_, [&](const Bound& bound) { return bound.assignment.target == target; });
  }

  void RequireColumns() const {
    const Place place{.file = "--map"};
    const std::vector<std::string_view> axes = {"cmd_x_mm", "cmd_y_mm", "cmd_z_mm"};
    const auto num_axes =
        std::ranges::count_if(axes, [&](auto axis) { return Has(axis); });
    if (Has("value_mm") == Has("actual_mm")) {
      throw InputError(place,
                       "it names value_mm (a deviation) or actual_mm (a position), one "
                       "of them",
                       "as value_mm=dev[um]");
    }
    if (num_axes == 0) {
      throw InputError(place,
                       "it does not say which column is the commanded position",
                       "as cmd_x_mm=target[mm]; several axes: also nx, ny, nz");
    }
    const bool has_normal = Has("nx") || Has("ny") || Has("nz");
    if (num_axes > 1 && !has_normal) {
      throw InputError(place,
                       "with more than one commanded axis it must say along which the "
                       "value is measured",
                       "as nx:=1 (then ny and nz are 0), or nx=3,ny=4");
    }
    if (Has("actual_mm") && num_axes > 1) {
      throw InputError(place,
                       "actual_mm is a position along the single commanded axis",
                       "with several axes give the deviation, value_mm");
    }
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
    if (std::ranges::any_of(row.n, Known)) {
      for (double& component : row.n) component = Known(component) ? component : 0;
    }
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
  void Assign(std::int64_t Row::*member,
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
        Has("actual_mm")
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
