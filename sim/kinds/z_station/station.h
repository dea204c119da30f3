#pragma once

#include <cstdint>
#include <memory>

#include "sim/base/rng.h"
#include "sim/firmware/kinds/z_station/klipper.h"
#include "sim/kinds/z_station/world.h"

namespace caltwin {

/// What is true of nozzle, endstop switch, magnetic switch probe and print surface.
/// Lengths along z; the head's carriage scale is such that the drawn, cold nozzle's tip
/// stands at the bare bed with the carriage at 0.
struct ZStation {
  double switch_mm = 1.5;   ///< Where the endstop switch triggers, over the bare bed.
  double nozzle_mm = 0;     ///< How much longer the nozzle is than drawn.
  double ooze_mm = 0;       ///< Plastic on its tip, squashed by the switch to this.
  double body_mm = 6.5;     ///< The probe's body hangs so far below the drawn tip.
  double trigger_mm = 0.5;  ///< Body over what its knob touches, at the trigger.
  double plate_mm = 0;      ///< Thickness of what lies on the bed.
  /// @name The bed's surface, about its middle; the bowl's height is at 100 mm from it.
  double bed_slope_x_mrad = 0, bed_slope_y_mrad = 0, bed_bowl_mm = 0;
  double dock_misses = 0;  ///< 1: the magnets do not take the probe along.
  double endstop_scatter_mm = 0.002;
  double probe_scatter_mm = 0.002;
  double worn_mm = 0;  ///< Of the endstop switch: each trigger up to this late, skewed.
  /// @name Growth [mm/K] from 20 degC
  double nozzle_mm_per_k = 0.0002;
  double bed_mm_per_k = 0.0005;
  double frame_mm_per_k = 0.002;  ///< Of the chamber's: lifts the head.
  double surface_mm_per_k = 0;    ///< Of the bed's: where it is probed, over its edge.
  double trigger_mm_per_k = 0;    ///< Of the chamber's: of the probe's trigger_mm.
  double ooze_flows_c = 0;        ///< There is ooze from this nozzle temperature on.
};

/// The station with its chance, in closed form or in MuJoCo.
///
///   tip = carriage + frame - nozzle,  body = tip_drawn - body,  surface = bed + plate
///   nozzle on switch: tip - ooze = switch, body on switch: body = switch,
///   probe on bed: body - trigger = surface
///
/// A probe that was left in its dock: the switch meets the nozzle instead of the body,
/// the bed nothing that would trigger.
class ZStationTwin : public ZStationPlant {
 public:
  /// @param is_physics  contacts and the switches' springs are MuJoCo's (ZStationWorld)
  ZStationTwin(const ZStation& station,
               bool is_physics,
               std::uint64_t seed,
               std::uint64_t sample,
               const Eigen::Vector2d& middle_mm = {117.5, 117.5});

  std::optional<double> Touch(ZTouch touch, const Eigen::Vector2d& at_mm) override;
  void Heat(char what, double temp_c) override;

  /// An operator's act: another nozzle, another plate.
  ZStation* station() { return &station_; }
  /// Another: the nozzle is clean until it is heated anew, or false: no longer.
  void Wipe(bool is_wiped = true) { is_wiped_ = is_wiped; }
  bool is_wiped() const { return is_wiped_; }
  const ZStation& station() const { return station_; }
  const Eigen::Vector2d& middle_mm() const { return middle_mm_; }
  /// The probe's body over what its knob touches, at the trigger, as warm as it is.
  double Trigger_mm() const;
  /// How the parts stand now, the bed where it is asked for.
  ZStationBuild BuildAt(const Eigen::Vector2d& at_mm) const;
  /// Clear height of the clean nozzle's tip over the print surface there.
  double Gap_mm(double carriage_mm, const Eigen::Vector2d& at_mm) const;

 private:
  double Surface_mm(const Eigen::Vector2d& at_mm) const;
  double TipOver_mm() const;
  double Late_mm(ZTouch touch);

  ZStation station_;
  Rng rng_;
  Eigen::Vector2d middle_mm_;
  std::unique_ptr<ZStationWorld> world_{};  ///< Null: in closed form.
  double nozzle_k_ = 0, bed_k_ = 0, chamber_k_ = 0;
  bool is_wiped_ = false;
};

}  // namespace caltwin
