#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "sim/base/median.h"
#include "sim/base/units.h"
#include "sim/measure/import/fields.h"
#include "sim/measure/import/growth_fit.h"
#include "sim/measure/import/klipper_thermal.h"

namespace caltwin {
namespace {

constexpr double kFarOff_mm = 1;
constexpr double kFinestStep_mm = 1e-7;
constexpr const char* kCampaign = "thermal_drift";

/// A column of the log and where it goes.
struct LogColumn {
  std::string_view name{};
  double Row::*member = nullptr;  ///< Null: kept as an extra column.
  std::string_view extra{};
};
constexpr std::array kColumns = {LogColumn{"frame_t", &Row::temp_frame_c},
                                 LogColumn{"chamber_t", &Row::temp_chamber_c},
                                 LogColumn{"bed_t", &Row::temp_bed_c},
                                 LogColumn{"he_t", nullptr, "temp_hotend_c"},
                                 LogColumn{"bed_target", nullptr, "target_bed_c"},
                                 LogColumn{"he_target", nullptr, "target_hotend_c"}};

FrameLogHeader HeaderIn(const std::vector<TextLine>& lines, Faults* faults) {
  FrameLogHeader header;
  double max_z_mm = kUnknown;
  for (const TextLine& line : lines) {
    const std::size_t equals = line.text.find('=');
    if (!line.text.starts_with("# ") || equals == std::string_view::npos) continue;
    const std::string key = PlainWord(line.text.substr(2, equals - 2));
    const std::string_view written = line.text.substr(equals + 1);
    if (key == "printer") header.printer = std::string(written);
    const auto number = NumberOf(written);
    if (key == "stepdist") {
      header.step_line = line.line;
      if (!number || *number < kFinestStep_mm || *number > 1) {
        faults->Add({.line = line.line, .column = static_cast<int>(equals) + 2},
                    fmt::format("step_dist = '{}' is no length of a step", written),
                    "in mm, from 1e-7 to 1");
      } else {
        header.step_mm = *number;
      }
    }
    const bool is_size = number && *number > 0;
    if (key == "coeff" && is_size && *number < 200) {
      header.expansion_per_k = FractionFromPpm(*number);
    }
    if (key == "framezlength" && is_size) header.frame_length_mm = *number;
    if (key == "maxz" && is_size) max_z_mm = *number;
  }
  if (!Known(header.frame_length_mm)) header.frame_length_mm = max_z_mm;
  return header;
}

std::string AccountOf(std::string_view which, const GrowthFit& fit) {
  const auto lag = [](double lag_s) {
    return lag_s > 0 ? fmt::format(" (lag {:.0f} s)", lag_s) : "";
  };
  return fmt::format(
      "{}: {:.2f} um/K frame{}, {:.2f} um/K bed{}, rms {:.2f} um{}",
      which,
      UmFromMm(fit.frame_mm_per_k),
      lag(fit.frame_lag_s),
      UmFromMm(fit.bed_mm_per_k),
      lag(fit.bed_lag_s),
      UmFromMm(fit.rms_mm),
      Known(fit.held_out_rms_mm)
          ? fmt::format("; of hours left out {:.2f} um", UmFromMm(fit.held_out_rms_mm))
          : "");
}

class FrameLogReader {
 public:
  FrameLogReader(const std::string& text, std::string name)
      : text_(text), name_(std::move(name)), csv_(text_, name_, &faults_) {}

  Imported Read(const ImportOptions& options) {
    header_ = HeaderIn(LinesOf(text_), &faults_);
    faults_.ThrowIfAny();
    ReadColumns();
    if (options.step_mm) {
      header_.step_mm = *options.step_mm;
      header_.step_line = 0;
    }
    RequireStep();
    while (const auto record = csv_.Next()) ReadRecord(*record);
    faults_.ThrowIfAny();
    if (imported_.table.rows.empty()) {
      throw InputError({.file = name_}, "no readings: only a header stands here");
    }
    const GrowthPerKelvin growth = GrowthOf(imported_.table, header_);
    CheckStep(growth);
    Explain(growth, options);
    return std::move(imported_);
  }

 private:
  void ReadColumns() {
    const auto header = csv_.Next();
    if (header) columns_ = *header;
    for (const std::string_view wanted : {"time", "mcu_pos_z", "frame_t"}) {
      if (IndexOf(wanted)) continue;
      faults_.Add(
          {.file = name_, .line = header ? header->front().line : 1, .column = 1},
          fmt::format("the column '{}' is missing", wanted),
          "a frame expansion log has sample, time, mcu_pos_z, frame_t, "
          "chamber_t, bed_t ...; a probe drift log is JSON. Other tables: "
          "caltwin import csv FILE --map ...");
    }
    faults_.ThrowIfAny();
    time_at_ = IndexOf("time").value_or(0);
    steps_at_ = IndexOf("mcu_pos_z").value_or(0);
    for (const LogColumn& column : kColumns) {
      if (column.member == nullptr && IndexOf(column.name)) {
        imported_.table.extra_columns.emplace_back(column.extra);
      }
    }
  }

  std::optional<std::size_t> IndexOf(std::string_view column) const {
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (columns_[i].text == column) return i;
    }
    return std::nullopt;
  }

  void RequireStep() {
    if (Known(header_.step_mm)) return;
    throw InputError(
        PlaceOf(columns_[steps_at_], name_),
        "mcu_pos_z counts motor steps, and nothing here says how long one is",
        "say it: --step-mm, rotation_distance / gear ratio / (full steps "
        "per turn * microsteps); 0.0025 for a Voron 2");
  }

  void ReadRecord(const CsvRecord& record) {
    if (record.size() != columns_.size()) {
      faults_.Add(PlaceOf(record.front(), name_),
                  fmt::format("{} fields, where the header names {} columns",
                              record.size(),
                              columns_.size()));
      return;
    }
    Row row{.campaign = kCampaign,
            .kind = RowKind::kTouch,
            .setup = "pin",
            .place = PlaceOf(record.front(), name_)};
    const CsvField& clock = record[time_at_];
    const auto time_s = ClockTime_s(clock.text);
    if (!time_s) {
      faults_.Add(PlaceOf(clock, name_),
                  fmt::format("time = '{}' is no time", clock.text),
                  "as 2021/06/13-20:05:00");
    }
    const CsvField& steps = record[steps_at_];
    const double position = NumberIn(steps, "mcu_pos_z", name_, &faults_);
    if (imported_.table.rows.empty()) {
      start_s_ = time_s.value_or(0);
      start_steps_ = position;
    }
    row.t_s = time_s.value_or(0) - start_s_;
    row.cmd_mm[2] = 0;
    row.dir[2] = -1;
    row.n = {0, 0, 1};
    row.settings = "s1";
    row.feature = "pin.top";
    row.value_mm = (position - start_steps_) * header_.step_mm;
    if (const auto sample = IndexOf("sample")) {
      const double rep = NumberIn(record[*sample], "sample", name_, &faults_);
      if (rep >= 0 && rep < 1e9) row.rep = static_cast<std::int64_t>(rep);
    }
    for (const LogColumn& column : kColumns) {
      const auto index = IndexOf(column.name);
      if (!index) continue;
      if (column.member == nullptr) {
        row.extra.push_back(record[*index].text);
      } else if (!record[*index].text.empty()) {
        row.*column.member =
            NumberIn(record[*index], std::string(column.name), name_, &faults_);
      }
    }
    imported_.table.rows.push_back(std::move(row));
  }

  void CheckStep(const GrowthPerKelvin& growth) {
    const std::string fault = StepFault(growth, header_);
    if (fault.empty()) return;
    if (header_.step_line == 0) {
      imported_.warnings.push_back(fault);
      return;
    }
    std::string hint = "give the true length of a step: --step-mm";
    const bool is_voron2 = header_.printer.find("voron_v2") != std::string::npos;
    if (is_voron2 && StepFault({.growth_mm_per_k = growth.growth_mm_per_k / 5,
                                .range_k = growth.range_k,
                                .metres_needed = growth.metres_needed / 5,
                                .ratio = growth.ratio / 5},
                               header_)
                         .empty()) {
      hint = fmt::format(
          "{} is the step of a Z motor without its 80:16 gears: a {} moves a fifth of "
          "it, {}. With --step-mm {} the frame grows by {:.1f} um/K",
          header_.step_mm,
          header_.printer,
          header_.step_mm / 5,
          header_.step_mm / 5,
          UmFromMm(std::abs(growth.growth_mm_per_k) / 5));
    }
    throw InputError(
        {.file = name_, .line = header_.step_line, .column = 1}, fault, hint);
  }

  void Explain(const GrowthPerKelvin& growth, const ImportOptions& options) {
    const RowTable& table = imported_.table;
    imported_.recognised = {
        fmt::format("a frame expansion log{}: {} readings in {:.1f} h",
                    header_.printer.empty() ? "" : " of " + header_.printer,
                    table.rows.size(),
                    table.rows.back().t_s / SFromH(1.0)),
        fmt::format("a motor step is {} mm{}",
                    header_.step_mm,
                    header_.step_line == 0
                        ? ", as you say"
                        : fmt::format(" (line {})", header_.step_line))};
    if (growth.ratio != 0) {
      imported_.recognised.push_back(fmt::format(
          "plain least squares: the trigger height changes by {:.2f} um per kelvin of "
          "the frame, as if {:.2f} m of it grew",
          UmFromMm(growth.growth_mm_per_k),
          growth.metres_needed));
      imported_.recognised.push_back(AccountOf("without lag", PlainGrowth(table)));
      imported_.recognised.push_back(AccountOf("with lags", LaggedGrowth(table)));
    }
    imported_.assumed = {
        "mcu_pos_z counts upwards; value = (mcu_pos_z - the first) * step, + is up",
        "the nozzle touched one pin from above; where it stands is not recorded"};
    WarnOfFarReadings();
    imported_.header.settings["s1"].steps_per_mm["z"] = 1 / header_.step_mm;
    imported_.header.instruments["probe"] = {
        .kind = "probe", .resolution_um = UmFromMm(header_.step_mm)};
    const std::string campaign =
        options.campaign.empty() ? kCampaign : options.campaign;
    imported_.header.campaigns[campaign] = {.instrument = "probe", .plan = "drift"};
    for (Row& row : imported_.table.rows) row.campaign = campaign;
  }

  void WarnOfFarReadings() {
    std::vector<double> values_mm;
    for (const Row& row : imported_.table.rows) values_mm.push_back(row.value_mm);
    const double median_mm = Median(values_mm);
    int count = 0;
    int first_line = 0;
    for (const Row& row : imported_.table.rows) {
      if (std::abs(row.value_mm - median_mm) < kFarOff_mm) continue;
      if (count++ == 0) first_line = row.place.line;
    }
    if (count == 0) return;
    imported_.warnings.push_back(fmt::format(
        "{} of {} readings lie more than {} mm from the median, the first in line {}: "
        "homing went wrong there. They are kept; diagnosis flags them",
        count,
        imported_.table.rows.size(),
        kFarOff_mm,
        first_line));
  }

  const std::string& text_;
  std::string name_;
  Faults faults_;
  CsvReader csv_;
  CsvRecord columns_;
  std::size_t time_at_ = 0;
  std::size_t steps_at_ = 0;  ///< Of mcu_pos_z.
  FrameLogHeader header_;
  Imported imported_;
  double start_s_ = 0;
  double start_steps_ = 0;
};

}  // namespace

Imported ReadFrameLog(const std::string& text,
                      const std::string& name,
                      const ImportOptions& options) {
  return FrameLogReader(text, name).Read(options);
}

}  // namespace caltwin
