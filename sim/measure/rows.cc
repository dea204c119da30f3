#include "sim/measure/rows.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/text_file.h"
#include "sim/measure/columns.h"
#include "sim/measure/csv.h"

namespace caltwin {
namespace {

constexpr std::size_t kMostFaults = 1000;  // Beyond these no one reads them.
constexpr double kUnitTolerance = 1e-3;    // 0.707, 0.707 is a unit vector to people.

constexpr std::string_view kRequired[] = {"campaign", "value_mm"};
constexpr std::string_view kPose[] = {"cmd_x_mm", "cmd_y_mm", "cmd_z_mm"};

// What importers keep beside the rows, for people: nobody's mistake.
constexpr std::string_view kKept[] = {"height_mm",
                                      "count_a",
                                      "count_b",
                                      "count_c",
                                      "temp_hotend_c",
                                      "target_bed_c",
                                      "target_hotend_c"};
constexpr std::string_view kKeptOfCmm = "cmm_";

bool IsKept(std::string_view name) {
  return std::ranges::find(kKept, name) != std::end(kKept) ||
         name.starts_with(kKeptOfCmm);
}

std::vector<std::string> KnownNames() {
  std::vector<std::string> names = {"row", "kind", "value_mm"};
  for (const Column& column : AllColumns()) names.emplace_back(column.name);
  return names;
}

std::optional<double> ParseNumber(std::string_view text) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  double value = 0;
  const auto [end, error] =
      std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

class Reader {
 public:
  Reader(const std::string& text, std::string name)
      : name_(std::move(name)), csv_(text, name_, &faults_) {}

  RowTable Read() {
    const auto header = csv_.Next();
    if (!header) {
      faults_.ThrowIfAny();
      throw InputError({.file = name_, .line = 1, .column = 1},
                       "no measured rows: the file is empty",
                       kHeaderHint);
    }
    ReadHeader(*header);
    faults_.ThrowIfAny();
    while (const auto record = csv_.Next()) {
      ReadRecord(*record);
      if (faults_.size() >= kMostFaults) break;
    }
    faults_.ThrowIfAny();
    if (table_.rows.empty()) {
      throw InputError(PlaceOf(header->front()),
                       "no measured rows: only a header stands here");
    }
    // A table without numbers is one whose rows all have the number 0.
    if (table_.rows.size() == 1 && table_.rows[0].row == 0) table_.rows[0].row = 1;
    table_.comments = csv_.comments();
    return std::move(table_);
  }

 private:
  static constexpr const char* kHeaderHint =
      "the first line names the columns: campaign, value_mm, cmd_x_mm, dir_x ... "
      "(docs/data-format.md)";

  /// What a field of the file belongs to; exactly one applies.
  struct Target {
    enum class What { kRow, kKind, kValue, kColumn, kExtra } what = What::kExtra;
    const Column* column = nullptr;
    std::string name{};
  };

  Place PlaceOf(const CsvField& field) const {
    return {.file = name_, .line = field.line, .column = field.column};
  }

  void ReadHeader(const CsvRecord& header) {
    const std::vector<std::string> known = KnownNames();
    std::set<std::string> seen;
    std::vector<const CsvField*> unknown;
    for (const CsvField& field : header) {
      targets_.push_back(TargetNamed(field.text));
      if (targets_.back().what == Target::What::kExtra) unknown.push_back(&field);
      if (!seen.insert(field.text).second) {
        faults_.Add(PlaceOf(field),
                    fmt::format("the column '{}' stands twice", field.text));
      }
    }
    if (unknown.size() == header.size()) {
      const bool other_separator =
          header.front().text.find_first_of(";\t") != std::string::npos;
      throw InputError(
          PlaceOf(header.front()),
          "this is no header of measured rows: no column is known",
          other_separator ? "columns are separated by commas" : kHeaderHint);
    }
    CheckRequired(header.front(), seen, unknown);
    for (const CsvField* field : unknown) {
      table_.extra_columns.push_back(field->text);
      if (field->text.empty()) faults_.Add(PlaceOf(*field), "a column without a name");
      if (IsKept(field->text)) continue;
      const std::string nearest = NearestWord(field->text, known);
      table_.remarks.push_back(
          fmt::format("{}: the column '{}' is not known and not used{}",
                      ToString(PlaceOf(*field)),
                      field->text,
                      nearest.empty() || seen.contains(nearest)
                          ? ""
                          : fmt::format("; did you mean '{}'?", nearest)));
    }
  }

  static Target TargetNamed(const std::string& name) {
    if (name == "row") return {.what = Target::What::kRow, .name = name};
    if (name == "kind") return {.what = Target::What::kKind, .name = name};
    if (name == "value_mm") return {.what = Target::What::kValue, .name = name};
    for (const Column& column : AllColumns()) {
      if (column.name == name) {
        return {.what = Target::What::kColumn, .column = &column, .name = name};
      }
    }
    return {.what = Target::What::kExtra, .name = name};
  }

  void CheckRequired(const CsvField& first,
                     const std::set<std::string>& seen,
                     const std::vector<const CsvField*>& unknown) {
    std::vector<std::string> written;
    for (const CsvField* field : unknown) written.push_back(field->text);
    for (const std::string_view required : kRequired) {
      const std::string name(required);
      if (seen.contains(name)) continue;
      const std::string nearest = NearestWord(name, written);
      faults_.Add(PlaceOf(first),
                  fmt::format("the column '{}' is missing", name),
                  nearest.empty() ? "" : fmt::format("is '{}' meant for it?", nearest));
    }
    pose_columns_ =
        static_cast<int>(std::ranges::count_if(kPose, [&](std::string_view name) {
          return seen.contains(std::string(name));
        }));
    if (pose_columns_ == 0) {
      faults_.Add(PlaceOf(first),
                  "the commanded pose is missing",
                  "at least one column of cmd_x_mm, cmd_y_mm, cmd_z_mm");
    }
  }

  void ReadRecord(const CsvRecord& record) {
    if (record.size() != targets_.size()) {
      faults_.Add(
          PlaceOf(record[std::min(record.size(), targets_.size()) - 1]),
          fmt::format("{} fields, where the header names {} columns",
                      record.size(),
                      targets_.size()),
          record.size() > targets_.size()
              ? "the decimal mark is a dot; a text with a comma stands in quotes"
              : "an unknown value is an empty field between its commas");
      return;
    }
    Row row{.place = PlaceOf(record.front())};
    number_.reset();
    for (std::size_t i = 0; i < record.size(); ++i) {
      ReadField(targets_[i], record[i], &row);
    }
    if (row.campaign.empty()) {
      faults_.Add(row.place, "campaign is empty", "rows of one campaign share a name");
    }
    CheckPose(&row);
    CheckNumber(&row);
    table_.rows.push_back(std::move(row));
  }

  void ReadField(const Target& target, const CsvField& field, Row* row) {
    switch (target.what) {
      case Target::What::kRow:
        number_ = Integer(
            target.name, field, {-1e15, 1e15}, "rows are counted, from any number");
        row->row = number_.value_or(0);
        return;
      case Target::What::kKind:
        ReadKind(field, row);
        return;
      case Target::What::kValue:
        row->value_mm = Number(target.name, field, kAnyNumber, "");
        if (field.text.empty()) {
          faults_.Add(PlaceOf(field),
                      "value_mm is empty",
                      "a row without a reading is left out of the file");
        }
        return;
      case Target::What::kColumn:
        std::visit([&](auto member) { Assign(member, *target.column, field, row); },
                   target.column->member);
        return;
      case Target::What::kExtra:
        row->extra.push_back(field.text);
        return;
    }
  }

  void ReadKind(const CsvField& field, Row* row) {
    if (field.text.empty()) return;
    const auto* found = std::ranges::find(kRowKinds, field.text);
    if (found == kRowKinds.end()) {
      const std::string nearest =
          NearestWord(field.text, {kRowKinds.begin(), kRowKinds.end()});
      faults_.Add(PlaceOf(field),
                  fmt::format("kind = '{}' is not known", field.text),
                  (nearest.empty() ? "" : fmt::format("did you mean '{}'? ", nearest)) +
                      fmt::format("It may be: {}", fmt::join(kRowKinds, ", ")));
      return;
    }
    row->kind = static_cast<RowKind>(found - kRowKinds.begin());
  }

  void Assign(double Row::*member,
              const Column& column,
              const CsvField& field,
              Row* row) {
    row->*member = Number(column.name, field, column.bounds, column.hint);
  }
  void Assign(Component component,
              const Column& column,
              const CsvField& field,
              Row* row) {
    double& number = (row->*component.numbers)[component.index];
    number = Number(column.name, field, column.bounds, column.hint);
    const bool is_sense = column.name.starts_with("dir_");
    if (is_sense && Known(number) && number != std::round(number)) {
      FailValue(column.name, field, "is not -1, 0 or 1", column.hint);
    }
  }
  void Assign(std::optional<std::int64_t> Row::*member,
              const Column& column,
              const CsvField& field,
              Row* row) {
    row->*member = Integer(column.name, field, column.bounds, column.hint);
  }
  void Assign(std::string Row::*member,
              const Column& /*column*/,
              const CsvField& field,
              Row* row) {
    row->*member = field.text;
  }

  void FailValue(std::string_view name,
                 const CsvField& field,
                 const std::string& what,
                 std::string_view hint) {
    faults_.Add(PlaceOf(field),
                fmt::format("{} = '{}' {}", name, field.text, what),
                std::string(hint));
  }

  double Number(std::string_view name,
                const CsvField& field,
                Bounds bounds,
                std::string_view hint) {
    if (field.text.empty()) return kUnknown;
    const auto value = ParseNumber(field.text);
    if (!value) {
      FailValue(name,
                field,
                "is not a number",
                field.text.find(',') != std::string::npos ? "the decimal mark is a dot"
                                                          : hint);
    } else if (!std::isfinite(*value)) {
      FailValue(
          name, field, "is not a finite number", "an unknown value is an empty field");
    } else if (*value < bounds.min || *value > bounds.max) {
      FailValue(name,
                field,
                bounds.max == kAnyNumber.max && bounds.min == 0
                    ? "is below 0"
                    : fmt::format("is outside {} .. {}", bounds.min, bounds.max),
                hint);
    } else {
      return *value;
    }
    return kUnknown;
  }

  std::optional<std::int64_t> Integer(std::string_view name,
                                      const CsvField& field,
                                      Bounds bounds,
                                      std::string_view hint) {
    const double value = Number(name, field, bounds, hint);
    if (!Known(value)) return std::nullopt;
    if (value != std::round(value))
      FailValue(name, field, "is not a whole number", hint);
    return static_cast<std::int64_t>(value);
  }

  void CheckPose(Row* row) {
    const bool has_pose = std::ranges::any_of(row->cmd_mm, Known);
    if (!has_pose) {
      faults_.Add(row->place,
                  "the commanded pose is empty",
                  "at least one of cmd_x_mm, cmd_y_mm, cmd_z_mm");
      return;
    }
    if (std::ranges::any_of(row->n, Known)) return CheckUnit(row);
    if (pose_columns_ > 1) {
      faults_.Add(
          row->place,
          "nx, ny, nz are missing",
          "with more than one commanded axis a row says along which unit vector "
          "its value is measured");
      return;
    }
    const auto* axis = std::ranges::find_if(row->cmd_mm, Known);
    const std::size_t index = static_cast<std::size_t>(axis - row->cmd_mm.begin());
    row->n = {0, 0, 0};
    row->n[index] = row->kind == RowKind::kTouch && row->dir[index] == 1 ? -1 : 1;
  }

  void CheckUnit(Row* row) {
    double square = 0;
    for (double& component : row->n) {
      if (!Known(component)) component = 0;
      square += component * component;
    }
    const double length = std::sqrt(square);
    if (std::abs(length - 1) > kUnitTolerance) {
      faults_.Add(row->place,
                  fmt::format("(nx, ny, nz) has the length {:.4g}", length),
                  "it is a unit vector: its length is 1");
    } else if (std::abs(length - 1) > 1e-9) {
      for (double& component : row->n) component /= length;
    }
  }

  void CheckNumber(Row* row) {
    const bool has_column = std::ranges::any_of(
        targets_, [](const Target& t) { return t.what == Target::What::kRow; });
    if (!has_column) {
      row->row = static_cast<std::int64_t>(table_.rows.size()) + 1;
    } else if (!number_) {
      faults_.Add(row->place,
                  "row is empty or no number",
                  "number every row, or leave the column out: then they count in file "
                  "order");
    } else if (const auto [first, is_new] = line_of_.emplace(row->row, row->place.line);
               !is_new) {
      faults_.Add(
          row->place,
          fmt::format("row = {} stands in line {} already", row->row, first->second),
          "a row's number tells it from the others");
    }
  }

  std::string name_;
  Faults faults_;
  CsvReader csv_;
  std::vector<Target> targets_;
  int pose_columns_ = 0;
  std::map<std::int64_t, int> line_of_;
  std::optional<std::int64_t> number_{};  ///< That the row being read states.
  RowTable table_;
};

}  // namespace

RowTable ReadRows(const std::filesystem::path& file) {
  return ParseRows(ReadTextFile(file, kLargestData_bytes), file.string());
}

RowTable ParseRows(const std::string& text, const std::string& name) {
  RequireText(text, name);
  return Reader(text, name).Read();
}

}  // namespace caltwin
