#include "sim/twin/z_station.h"

#include <cmath>

namespace caltwin {

namespace {
constexpr double kCold_c = 20;
}  // namespace

void ZStationTwin::Heat(char what, double temp_c) {
  double& warmer_k = what == 'n' ? nozzle_k_ : what == 'b' ? bed_k_ : chamber_k_;
  warmer_k = temp_c - kCold_c;
}

// The print surface over the bare, cold bed.
double ZStationTwin::Surface_mm() const {
  return station_.plate_mm + station_.bed_mm_per_k * bed_k_;
}

// The clean tip over the carriage's own scale.
double ZStationTwin::TipOver_mm() const {
  return station_.frame_mm_per_k * chamber_k_ - station_.nozzle_mm -
         station_.nozzle_mm_per_k * nozzle_k_;
}

double ZStationTwin::Gap_mm(double carriage_mm) const {
  return carriage_mm + TipOver_mm() - Surface_mm();
}

std::optional<double> ZStationTwin::Touch(ZTouch touch) {
  const double body_over_mm = station_.frame_mm_per_k * chamber_k_ - station_.body_mm;
  // The switch stands on the bed's edge and rises with it.
  const double switch_mm = station_.switch_mm + station_.bed_mm_per_k * bed_k_;
  const bool is_on_switch = touch != ZTouch::kProbeOnBed;
  double late_mm =
      (is_on_switch ? station_.endstop_scatter_mm : station_.probe_scatter_mm) *
      rng_.Normal();
  if (is_on_switch) late_mm -= station_.worn_mm * rng_.Uniform() * rng_.Uniform();
  switch (touch) {
    case ZTouch::kNozzleOnSwitch:
      return switch_mm + station_.ooze_mm - TipOver_mm() + late_mm;
    case ZTouch::kBodyOnSwitch:
      return switch_mm - body_over_mm + late_mm;
    case ZTouch::kProbeOnBed:
      return Surface_mm() + station_.trigger_mm - body_over_mm + late_mm;
  }
  return std::nullopt;
}

}  // namespace caltwin
