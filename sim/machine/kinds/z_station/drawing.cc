#include "sim/machine/kinds/z_station/drawing.h"

#include <algorithm>
#include <array>

namespace caltwin {
namespace {

// By ZReading.
constexpr std::array<std::string_view, 4> kFeatures = {
    "switch.nozzle", "switch.body", "bed.probe", "bed.gap"};

}  // namespace

std::string_view FeatureOf(ZReading reading) {
  return kFeatures[static_cast<std::size_t>(reading)];
}

std::optional<ZReading> ZReadingOf(std::string_view feature) {
  const auto* const found = std::ranges::find(kFeatures, feature);
  if (found == kFeatures.end()) return std::nullopt;
  return static_cast<ZReading>(found - kFeatures.begin());
}

double ZStationDrawing::Nominal_mm(ZReading reading) const {
  switch (reading) {
    case ZReading::kNozzleOnSwitch:
      return switch_mm;
    case ZReading::kBodyOnSwitch:
      return switch_mm + body_mm;
    case ZReading::kProbeOnBed:
      return body_mm + trigger_mm;
    case ZReading::kGapUnderNozzle:
      break;
  }
  return 0;
}

Eigen::Vector2d ZStationDrawing::PlaceOf_mm(ZReading reading) const {
  const bool is_on_switch =
      reading == ZReading::kNozzleOnSwitch || reading == ZReading::kBodyOnSwitch;
  return is_on_switch ? switch_at_mm : bed_at_mm;
}

ZStationDrawing ReadZStationDrawing(YamlMap* map) {
  ZStationDrawing drawing;
  const auto station = map->Optional("station");
  if (!station) return drawing;
  YamlMap keys = station->Map();
  drawing.switch_mm = keys.NumberOr("switch_mm", drawing.switch_mm, {-20, 50});
  drawing.body_mm = keys.NumberOr("body_mm", drawing.body_mm, {0, 50});
  drawing.trigger_mm = keys.NumberOr("trigger_mm", drawing.trigger_mm, {-1, 5});
  const auto place = [&](const char* key, Eigen::Vector2d* at_mm) {
    const auto value = keys.Optional(key);
    if (!value) return;
    const auto numbers = value->Numbers(2, {-1e4, 1e4});
    if (numbers.size() == 2) *at_mm = {numbers[0], numbers[1]};
  };
  place("switch_at_mm", &drawing.switch_at_mm);
  place("bed_at_mm", &drawing.bed_at_mm);
  keys.NoMoreKeys();
  return drawing;
}

}  // namespace caltwin
