#pragma once

#include <cstdint>

#include "sim/base/rng.h"
#include "sim/firmware/dialects/klipper_z.h"

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
  double endstop_scatter_mm = 0.002;
  double probe_scatter_mm = 0.002;
  double worn_mm = 0;  ///< Of the endstop switch: each trigger up to this late, skewed.
  /// @name Growth [mm/K] from 20 degC
  double nozzle_mm_per_k = 0.0002;
  double bed_mm_per_k = 0.0005;
  double frame_mm_per_k = 0.002;  ///< Of the chamber's: lifts the head.
};

/// In closed form.
///
///   tip = carriage + frame - nozzle,  body = tip_drawn - body,  surface = bed + plate
///   nozzle on switch: tip - ooze = switch, body on switch: body = switch,
///   probe on bed: body - trigger = surface
class ZStationTwin : public ZStationPlant {
 public:
  ZStationTwin(const ZStation& station, std::uint64_t seed, std::uint64_t sample)
      : station_(station), rng_(seed, sample, "z_station") {}

  std::optional<double> Touch(ZTouch touch) override;
  void Heat(char what, double temp_c) override;

  /// An operator's act: another nozzle, another plate, a wipe.
  ZStation* station() { return &station_; }
  /// Clear height of the clean nozzle's tip over the print surface.
  double Gap_mm(double carriage_mm) const;

 private:
  double Surface_mm() const;
  double TipOver_mm() const;

  ZStation station_;
  Rng rng_;
  double nozzle_k_ = 0, bed_k_ = 0, chamber_k_ = 0;
};

}  // namespace caltwin
