#include "sim/kinds/z_station/record.h"

#include <cmath>

#include <fmt/format.h>

#include "sim/base/units.h"
#include "sim/machine/kinds/z_station/drawing.h"

namespace caltwin {
namespace {

constexpr double kFeelerSigma_um = 3;  // Of hundredths.
constexpr double kFeelerStep_um = 10;

ZReading ReadingOf(ZTouch touch) {
  switch (touch) {
    case ZTouch::kBodyOnSwitch:
      return ZReading::kBodyOnSwitch;
    case ZTouch::kProbeOnBed:
      return ZReading::kProbeOnBed;
    case ZTouch::kNozzleOnSwitch:
      break;
  }
  return ZReading::kNozzleOnSwitch;
}

// As a program writes heights: to nanometres.
double Shown_mm(double height_mm) {
  return std::round(height_mm * 1e6) / 1e6;
}

}  // namespace

ZStationRecord::ZStationRecord(const ZCalibrationConfig& config, double sigma_mm)
    : position_endstop_mm_(config.position_endstop_mm) {
  header_.machine = "z_station";
  header_.tip_radius_mm = 0;
  header_.instruments["probe"] = {.kind = "probe", .sigma_um = UmFromMm(sigma_mm)};
  header_.instruments["feeler"] = {
      .kind = "feeler", .sigma_um = kFeelerSigma_um, .resolution_um = kFeelerStep_um};
  SetSwitchOffset_mm(config.switch_offset_mm);
}

void ZStationRecord::SetSwitchOffset_mm(double value) {
  settings_ = fmt::format("s{}", header_.settings.size() + 1);
  header_.settings[settings_].switch_offset_mm = value;
}

Row ZStationRecord::RowOf(const std::string& campaign,
                          ZReading reading,
                          const ZCircumstances& when,
                          double nominal_mm) const {
  Row row{.row = static_cast<std::int64_t>(rows_.rows.size()) + 1,
          .campaign = campaign,
          .kind = reading == ZReading::kGapUnderNozzle ? RowKind::kPosition
                                                       : RowKind::kTouch,
          .setup = std::string(FeatureOf(reading)),
          .home = fmt::format("h{}", when.homing),
          .settings = settings_,
          .t_s = std::round(10 * when.at_s) / 10};
  row.temp_nozzle_c = when.nozzle_c;
  row.temp_bed_c = when.bed_c;
  row.temp_chamber_c = when.chamber_c;
  const Eigen::Vector2d place_mm = drawing_.PlaceOf_mm(reading);
  row.cmd_mm = {place_mm[0], place_mm[1], nominal_mm};
  row.dir = {0, 0, -1};
  row.n = {0, 0, 1};
  row.feature = row.setup;
  return row;
}

void ZStationRecord::AddTouches(const std::string& campaign,
                                std::span<const ZTouched> touches,
                                bool is_wiped) {
  for (const ZTouched& touch : touches) {
    header_.campaigns[campaign].instrument = "probe";
    const ZReading reading = ReadingOf(touch.touch);
    const double nominal_mm = drawing_.Nominal_mm(reading);
    Row row = RowOf(campaign, reading, touch.when, nominal_mm);
    if (reading == ZReading::kProbeOnBed) {
      row.cmd_mm[0] = touch.place_mm[0];
      row.cmd_mm[1] = touch.place_mm[1];
    }
    row.feed_mm_s = touch.feed_mm_s;
    row.nozzle_wiped = is_wiped ? 1 : 0;
    // The controller calls the switch position_endstop, the drawing its height.
    row.value_mm = Shown_mm(touch.height_mm - position_endstop_mm_ +
                            drawing_.switch_mm - nominal_mm);
    rows_.rows.push_back(std::move(row));
  }
}

void ZStationRecord::AddGap(const std::string& campaign,
                            const ZCircumstances& when,
                            const FeelerReading& read,
                            bool is_wiped) {
  const std::string name = campaign + "_gap";
  header_.campaigns[name].instrument = "feeler";
  Row row = RowOf(name, ZReading::kGapUnderNozzle, when, Shown_mm(read.height_mm));
  row.nozzle_wiped = is_wiped ? 1 : 0;
  row.value_mm = Shown_mm(read.gap_mm - read.height_mm);
  rows_.rows.push_back(std::move(row));
}

}  // namespace caltwin
