#include "sim/kinds/z_station/station.h"

#include <algorithm>
#include <cmath>

#include "sim/base/units.h"
#include "sim/machine/machine.h"

namespace caltwin {

namespace {
constexpr double kCold_c = 20;
constexpr double kBowlAt_mm = 100;
constexpr double kApart_mm = 0.5;  // Of the points that tell a slope.
}  // namespace

ZStationTwin::ZStationTwin(const ZStation& station,
                           bool is_physics,
                           std::uint64_t seed,
                           std::uint64_t sample,
                           const Eigen::Vector2d& middle_mm)
    : station_(station), rng_(seed, sample, "z_station"), middle_mm_(middle_mm) {
  if (is_physics) {
    world_ =
        std::make_unique<ZStationWorld>(ShareFolder() / "models/z_station/model.xml");
  }
}

void ZStationTwin::Heat(char what, double temp_c) {
  double& warmer_k = what == 'n' ? nozzle_k_ : what == 'b' ? bed_k_ : chamber_k_;
  warmer_k = temp_c - kCold_c;
  if (what == 'n') is_wiped_ = false;
}

// The print surface over the bare, cold, flat bed.
double ZStationTwin::Surface_mm(const Eigen::Vector2d& at_mm) const {
  const Eigen::Vector2d from_mm = at_mm - middle_mm_;
  const Eigen::Vector2d slope(station_.bed_slope_x_mrad, station_.bed_slope_y_mrad);
  return station_.plate_mm +
         (station_.bed_mm_per_k + station_.surface_mm_per_k) * bed_k_ +
         1e-3 * slope.dot(from_mm) +
         station_.bed_bowl_mm * from_mm.squaredNorm() / (kBowlAt_mm * kBowlAt_mm);
}

// The clean tip over the carriage's own scale.
double ZStationTwin::TipOver_mm() const {
  return station_.frame_mm_per_k * chamber_k_ - station_.nozzle_mm -
         station_.nozzle_mm_per_k * nozzle_k_;
}

double ZStationTwin::Gap_mm(double carriage_mm, const Eigen::Vector2d& at_mm) const {
  return carriage_mm + TipOver_mm() - Surface_mm(at_mm);
}

double ZStationTwin::Trigger_mm() const {
  return station_.trigger_mm + station_.trigger_mm_per_k * chamber_k_;
}

ZStationBuild ZStationTwin::BuildAt(const Eigen::Vector2d& at_mm) const {
  const Eigen::Vector2d x_mm(kApart_mm / 2, 0), y_mm(0, kApart_mm / 2);
  const bool has_ooze = !is_wiped_ && kCold_c + nozzle_k_ >= station_.ooze_flows_c;
  return {.tip_mm = TipOver_mm() - (has_ooze ? station_.ooze_mm : 0),
          .body_mm = station_.frame_mm_per_k * chamber_k_ - station_.body_mm,
          .trigger_mm = Trigger_mm(),
          // The switch stands on the bed's edge and rises with it.
          .switch_mm = station_.switch_mm + station_.bed_mm_per_k * bed_k_,
          .surface_mm = Surface_mm(at_mm),
          .slope_x = (Surface_mm(at_mm + x_mm) - Surface_mm(at_mm - x_mm)) / kApart_mm,
          .slope_y = (Surface_mm(at_mm + y_mm) - Surface_mm(at_mm - y_mm)) / kApart_mm,
          .has_probe = station_.dock_misses < 1};
}

double ZStationTwin::Late_mm(ZTouch touch) {
  const bool is_on_switch = touch != ZTouch::kProbeOnBed;
  double late_mm =
      (is_on_switch ? station_.endstop_scatter_mm : station_.probe_scatter_mm) *
      rng_.Normal();
  if (is_on_switch) late_mm -= station_.worn_mm * rng_.Uniform() * rng_.Uniform();
  return late_mm;
}

std::optional<double> ZStationTwin::Touch(ZTouch touch, const Eigen::Vector2d& at_mm) {
  const ZStationBuild build = BuildAt(at_mm);
  const double late_mm = Late_mm(touch);
  if (!build.has_probe && touch == ZTouch::kProbeOnBed) return std::nullopt;
  const bool is_nozzle = touch == ZTouch::kNozzleOnSwitch || !build.has_probe;
  const double expected_mm = is_nozzle ? build.switch_mm - build.tip_mm
                             : touch == ZTouch::kBodyOnSwitch
                                 ? build.switch_mm - build.body_mm
                                 : build.surface_mm + build.trigger_mm - build.body_mm;
  if (!world_) return expected_mm + late_mm;
  const auto found_mm =
      world_->Lower(is_nozzle                        ? ZContact::kNozzleOnSwitch
                    : touch == ZTouch::kBodyOnSwitch ? ZContact::kBodyOnSwitch
                                                     : ZContact::kKnobOnSurface,
                    build,
                    expected_mm);
  if (!found_mm) return std::nullopt;
  return *found_mm + late_mm;
}

}  // namespace caltwin
