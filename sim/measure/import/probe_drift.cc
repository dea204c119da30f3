#include <cmath>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "sim/base/units.h"
#include "sim/measure/import/fields.h"
#include "sim/measure/import/klipper_thermal.h"

namespace caltwin {
namespace {

using nlohmann::json;

constexpr const char* kCampaign = "probe_drift";
constexpr const char* kForm =
    "a record is {\"ts\": seconds, \"z\": mm}, or {\"ts\": seconds, \"btemp\": degC, "
    "\"etemp\": degC, \"atherms\": [{\"id\": \"C\", \"temp\": degC}]}";

/// Temperatures at one time; unknown ones are kUnknown.
struct Temperatures {
  double t_s = 0;
  double bed_c = kUnknown, chamber_c = kUnknown, hotend_c = kUnknown;
};

double Between(double before, double after, double part) {
  return before + part * (after - before);
}

class DriftReader {
 public:
  DriftReader(const std::string& text, std::string name)
      : name_(std::move(name)), lines_(LinesOf(text)) {}

  Imported Read(const ImportOptions& options) {
    for (const TextLine& line : lines_) ReadLine(line);
    faults_.ThrowIfAny();
    if (table_.rows.empty()) {
      throw InputError({.file = name_}, "no readings of z stand here", kForm);
    }
    Imported imported;
    table_.extra_columns = {"temp_hotend_c"};
    const std::string campaign =
        options.campaign.empty() ? kCampaign : options.campaign;
    const double start_s = table_.rows.front().t_s;
    std::vector<double> values_mm;
    for (Row& row : table_.rows) {
      FillTemperatures(&row);
      row.t_s -= start_s;
      row.campaign = campaign;
      values_mm.push_back(row.value_mm);
    }
    const double step_mm = StepOf(values_mm);
    imported.recognised = {fmt::format(
        "a probe drift log: {} readings and {} records of temperature in {:.1f} h",
        table_.rows.size(),
        temperatures_.size(),
        table_.rows.back().t_s / SFromH(1.0))};
    if (step_mm > 0) {
      imported.recognised.push_back(
          fmt::format("readings come in steps of {:.4g} um", UmFromMm(step_mm)));
      imported.header.instruments["probe"] = {.kind = "probe",
                                              .resolution_um = UmFromMm(step_mm)};
      imported.header.campaigns[campaign].instrument = "probe";
    }
    imported.header.campaigns[campaign].plan = "drift";
    imported.assumed = {
        "z is the tool's height at the trigger in mm, + is up, its place the same "
        "throughout (it is not recorded)",
        "the sensor 'C' is the chamber's; temperatures between two records lie on a "
        "straight line"};
    imported.table = std::move(table_);
    return imported;
  }

 private:
  void ReadLine(const TextLine& line) {
    const Place place{.file = name_, .line = line.line, .column = 1};
    const json record = json::parse(line.text, nullptr, /*allow_exceptions=*/false);
    const auto time_s = Number(record, "ts");
    if (!record.is_object() || !time_s) {
      faults_.Add(place, "this line is no record of a probe drift log", kForm);
      return;
    }
    if (const auto z_mm = Number(record, "z")) {
      AddReading(*time_s, *z_mm, place);
    } else if (record.contains("btemp") || record.contains("etemp")) {
      AddTemperatures(record, *time_s);
    } else {
      faults_.Add(place, "this record has neither z nor a temperature", kForm);
    }
  }

  static std::optional<double> Number(const json& record, const char* key) {
    if (!record.is_object() || !record.contains(key)) return std::nullopt;
    const json& value = record.at(key);
    if (!value.is_number() || !std::isfinite(value.get<double>())) return std::nullopt;
    return value.get<double>();
  }

  void AddReading(double time_s, double z_mm, const Place& place) {
    Row row{.kind = RowKind::kTouch,
            .setup = "bed",
            .rep = static_cast<std::int64_t>(temperatures_.size()),
            .t_s = time_s,
            .place = place};
    row.cmd_mm[2] = 0;
    row.dir[2] = -1;
    row.n = {0, 0, 1};
    row.feature = "bed.top";
    row.value_mm = z_mm;
    table_.rows.push_back(std::move(row));
  }

  void AddTemperatures(const json& record, double time_s) {
    Temperatures at{.t_s = time_s,
                    .bed_c = Number(record, "btemp").value_or(kUnknown),
                    .hotend_c = Number(record, "etemp").value_or(kUnknown)};
    const auto sensors = record.find("atherms");
    if (sensors != record.end() && sensors->is_array()) {
      for (const json& sensor : *sensors) {
        const bool is_chamber =
            sensor.is_object() && sensor.contains("id") && sensor.at("id") == "C";
        if (is_chamber) at.chamber_c = Number(sensor, "temp").value_or(kUnknown);
      }
    }
    temperatures_[time_s] = at;
  }

  void FillTemperatures(Row* row) const {
    double hotend_c = kUnknown;
    if (!temperatures_.empty()) {
      auto after = temperatures_.upper_bound(row->t_s);
      const Temperatures& before =
          after == temperatures_.begin() ? after->second : std::prev(after)->second;
      if (after == temperatures_.end()) --after;
      const Temperatures& next = after->second;
      const double span_s = next.t_s - before.t_s;
      const double part = span_s > 0 ? (row->t_s - before.t_s) / span_s : 0;
      row->temp_bed_c = Between(before.bed_c, next.bed_c, part);
      row->temp_chamber_c = Between(before.chamber_c, next.chamber_c, part);
      hotend_c = Between(before.hotend_c, next.hotend_c, part);
    }
    row->extra = {Known(hotend_c) ? fmt::format("{:.3f}", hotend_c) : ""};
  }

  std::string name_;
  std::vector<TextLine> lines_;
  Faults faults_;
  RowTable table_;
  std::map<double, Temperatures> temperatures_;
};

}  // namespace

Imported ReadProbeDrift(const std::string& text,
                        const std::string& name,
                        const ImportOptions& options) {
  return DriftReader(text, name).Read(options);
}

}  // namespace caltwin
