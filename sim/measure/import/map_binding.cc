#include "sim/measure/import/map_binding.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/measure/import/fields.h"

namespace caltwin {
namespace {

Quantity QuantityOf(std::string_view target) {
  if (target.ends_with("_mm")) return Quantity::kLength;
  if (target == "t_s") return Quantity::kTime;
  if (target.starts_with("temp_")) return Quantity::kTemperature;
  if (target.ends_with("_mm_s")) return Quantity::kFeed;
  if (target.ends_with("_n")) return Quantity::kForce;
  if (target.ends_with("_deg")) return Quantity::kAngle;
  return Quantity::kPlain;
}

const Column* ColumnNamed(std::string_view name) {
  for (const Column& column : AllColumns()) {
    if (column.name == name) return &column;
  }
  return nullptr;
}

class Binder {
 public:
  Binder(const Spreadsheet& sheet, std::string name)
      : sheet_(sheet), name_(std::move(name)) {}

  Binding Run(const std::vector<Assignment>& map, const ImportOptions& options) {
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
      binding_.columns.push_back(std::move(bound));
    }
    faults_.ThrowIfAny();
    return std::move(binding_);
  }

 private:
  std::vector<std::string> Headings() const {
    std::vector<std::string> headings;
    for (const CsvField& field : sheet_.headings) headings.push_back(field.text);
    return headings;
  }

  void BindConstant(Bound* bound) const {
    bound->is_from_order = bound->assignment.target.starts_with("dir_") &&
                           bound->assignment.source == "order";
  }

  std::size_t SourceOf(const Assignment& assignment, const Place& place) {
    std::vector<std::string> found;
    for (std::size_t i = 0; i < sheet_.headings.size(); ++i) {
      const std::string& heading = sheet_.headings[i].text;
      const std::string source = PlainWord(assignment.source);
      // A unit in brackets is no part of a heading's name.
      if (heading == assignment.source || PlainWord(heading) == source ||
          PlainWord(heading.substr(0, heading.find_first_of("[("))) == source) {
        return i;
      }
    }
    const auto number = NumberOf(assignment.source);
    if (number && *number >= 1 &&
        *number <= static_cast<double>(sheet_.records.front().size()) &&
        *number == std::round(*number)) {
      return static_cast<std::size_t>(*number) - 1;
    }
    const std::string nearest = NearestWord(assignment.source, Headings());
    faults_.Add(
        place,
        fmt::format("{} has no column '{}'", name_, assignment.source),
        (nearest.empty() ? "" : fmt::format("did you mean '{}'? ", nearest)) +
            fmt::format("It has 1 to {}{}",
                        sheet_.records.front().size(),
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
    if (quantity == Quantity::kPlain) {
      if (assignment.unit.empty()) return;
      faults_.Add(place,
                  fmt::format("'{}' stands behind its source, and it has no unit",
                              assignment.unit),
                  fmt::format("{}={}", assignment.target, assignment.source));
      return;
    }
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
      binding_.assumed.push_back(fmt::format(
          "{} is in {}, as its heading says", assignment.target, in_heading->name));
    } else if (is_value) {
      faults_.Add(place,
                  "nothing says its unit",
                  fmt::format("say it: {}={}[um] or [mm], [inch], [thou]",
                              assignment.target,
                              assignment.source));
    } else {
      const std::string_view usual = UsualUnit(quantity);
      bound->unit = &FindUnit(usual, quantity, place);
      binding_.assumed.push_back(
          fmt::format("{} is in {}: nothing says so", assignment.target, usual));
    }
  }

  const Spreadsheet& sheet_;
  std::string name_;
  Faults faults_;
  Binding binding_;
};

void RequireColumns(const std::vector<Bound>& columns) {
  const Place place{.file = "--map"};
  const std::vector<std::string_view> axes = {"cmd_x_mm", "cmd_y_mm", "cmd_z_mm"};
  const auto num_axes =
      std::ranges::count_if(axes, [&](auto axis) { return Names(columns, axis); });
  if (Names(columns, "value_mm") == Names(columns, "actual_mm")) {
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
  const bool has_normal =
      Names(columns, "nx") || Names(columns, "ny") || Names(columns, "nz");
  if (num_axes > 1 && !has_normal) {
    throw InputError(place,
                     "with more than one commanded axis it must say along which the "
                     "value is measured",
                     "as nx:=1 (then ny and nz are 0), or nx=3,ny=4");
  }
  if (Names(columns, "actual_mm") && num_axes > 1) {
    throw InputError(place,
                     "actual_mm is a position along the single commanded axis",
                     "with several axes give the deviation, value_mm");
  }
}

}  // namespace

Binding Bind(const std::vector<Assignment>& map,
             const Spreadsheet& sheet,
             const std::string& name,
             const ImportOptions& options) {
  Binding binding = Binder(sheet, name).Run(map, options);
  RequireColumns(binding.columns);
  return binding;
}

bool Names(const std::vector<Bound>& columns, std::string_view target) {
  return std::ranges::any_of(
      columns, [&](const Bound& bound) { return bound.assignment.target == target; });
}

}  // namespace caltwin
