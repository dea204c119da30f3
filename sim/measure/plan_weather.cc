#include "sim/measure/plan_weather.h"

#include <cmath>
#include <iterator>
#include <numbers>

namespace caltwin {
namespace {

constexpr double kRoom_c = 20;
constexpr double kSwing_k = 0.15;
constexpr double kSwingPeriod_s = 18'000;
constexpr double kThermometer_k = 0.01;

constexpr double kScrewLag_s = 1200;
constexpr double kFrameLag_s = 3000;
constexpr double kBedLag_s = 900;
constexpr double kChamberLag_s = 1800;
constexpr double kChamberShare = 0.2;  // Of the screws' rise, in the air around.

// What a source switched on at 0 has added after t, to 1.
double Risen(double t_s, double lag_s) {
  return t_s <= 0 ? 0 : 1 - std::exp(-t_s / lag_s);
}

}  // namespace

void Weather::Heat(double now_s, const HeatPlan& plan) {
  const auto add = [&](Sensor sensor, double rise_k, double lag_s, bool is_bed) {
    sources_[static_cast<std::size_t>(sensor)].push_back(
        {.on_s = now_s + (is_bed ? plan.bed_on_s : plan.spindle_on_s),
         .off_s = now_s + (is_bed ? plan.bed_off_s : plan.spindle_off_s),
         .rise_k = rise_k,
         .lag_s = lag_s});
  };
  add(Sensor::kScrew, plan.screw_rise_k, kScrewLag_s, false);
  add(Sensor::kFrame, plan.frame_rise_k, kFrameLag_s, false);
  add(Sensor::kBed, plan.bed_rise_k, kBedLag_s, true);
  add(Sensor::kChamber, kChamberShare * plan.screw_rise_k, kChamberLag_s, false);
}

void Weather::Hold(Sensor sensor, double from_s, double temp_c) {
  held_c_[static_cast<std::size_t>(sensor)][from_s] = temp_c;
}

double Weather::At_c(Sensor sensor, double t_s) const {
  const auto& held_c = held_c_[static_cast<std::size_t>(sensor)];
  const auto after = held_c.upper_bound(t_s);
  if (after != held_c.begin()) return std::prev(after)->second;
  double temp_c =
      kRoom_c + kSwing_k * std::sin(2 * std::numbers::pi * t_s / kSwingPeriod_s);
  for (const Source& source : sources_[static_cast<std::size_t>(sensor)]) {
    temp_c += source.rise_k * (Risen(t_s - source.on_s, source.lag_s) -
                               Risen(t_s - source.off_s, source.lag_s));
  }
  return temp_c;
}

void Weather::Write(double t_s, Row* row) const {
  const auto shown_c = [&](Sensor sensor) {
    return std::round(At_c(sensor, t_s) / kThermometer_k) * kThermometer_k;
  };
  row->temp_screw_c = shown_c(Sensor::kScrew);
  row->temp_frame_c = shown_c(Sensor::kFrame);
  row->temp_bed_c = shown_c(Sensor::kBed);
  row->temp_chamber_c = shown_c(Sensor::kChamber);
  row->temp_ambient_c = shown_c(Sensor::kAmbient);
  const bool has_nozzle = !held_c_[static_cast<std::size_t>(Sensor::kNozzle)].empty();
  if (has_nozzle) row->temp_nozzle_c = shown_c(Sensor::kNozzle);
}

}  // namespace caltwin
