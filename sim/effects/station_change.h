#pragma once

#include "sim/base/units.h"
#include "sim/effects/effect.h"
#include "sim/effects/forms.h"

namespace caltwin {

/// Somebody changed the nozzle, or the plate, in the middle of the session.
///
///   nozzle: nozzle on switch = ... + step,  plate: probe on bed = ... + step,
///   from at_t on   [mm]
///
/// Positive: the new nozzle is longer, the new plate thicker. A homing does not end it.
struct StationChange {
  static constexpr std::array<std::string_view, 2> kAxes = {"nozzle", "plate"};
  static constexpr std::array kParameters = {
      Parameter{.name = "step_um",
                .unit = "um",
                .min = -20000,
                .max = 20000,
                .prior = Normal{.mean = 0, .sd = 500},
                .doc = "+: a longer nozzle, a thicker plate."},
      Parameter{.name = "at_t_s",
                .unit = "s",
                .min = 0,
                .max = 1e10,
                .prior = Uniform{.min = 0, .max = 36000},
                .doc = "Time in the session at which it happens.",
                .role = Role::kForm}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = values[1] = 0;
  }
  static Shown In(std::string_view axis) {
    return {.channel = axis == "nozzle" ? "nozzle" : "bed", .covariates = {"t"}};
  }
  static Forms Grid(const Machine&, std::string_view, const Extent& extent) {
    return OfOne(JumpTimes_s(extent));
  }
  static constexpr Effect kDeclaration = {
      .name = "station_change",
      .about = "Nozzle or plate was changed in the middle of the session.",
      .bucket = Bucket::kTime,
      .stage = Stage::kProbe,
      .parameters = kParameters,
      .formula = "nozzle on switch, or probe on bed: + step for t >= at_t",
      .source =
          "Nozzles of one kind differ by 0.05 to 0.2 mm, spring steel and glass plates "
          "by 0.4 to 4 mm.",
      .twin = "A probe put in anew shifts both touches that it takes part in.",
      .words = {.plot = "One of the touches against time: two levels.",
                .values = "0.05 to 0.2 mm for a nozzle, 0.4 to 4 mm for a plate.",
                .cause = "Nozzle or plate exchanged, or a nozzle that worked loose.",
                .effect = "The height calibrated before no longer holds.",
                .action = "Calibrate again after each change; if nobody changed "
                          "anything, look for a loose nozzle or a plate that slid."},
      .neutral = Neutral,
      .sight = Sight{.shown = In, .forms = Grid}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    if (!(asked.p[1] <= asked.at.t_s)) return;
    const T step_mm = MmFromUm(asked.p[0]);
    if (asked.axis == "nozzle") {
      errors->nozzle_mm += step_mm;
    } else if (asked.at.on_table) {
      errors->artefact_mm += step_mm;
    }
  }
};

}  // namespace caltwin
