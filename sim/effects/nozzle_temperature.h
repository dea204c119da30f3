#pragma once

#include "sim/base/units.h"
#include "sim/effects/effect.h"
#include "sim/effects/forms.h"

namespace caltwin {

/// Nozzle and heater block grow with their temperature.
///
///   nozzle on switch = ... + k dT,  lag d(dT)/dt = (T - T0) - dT   [mm]
///
/// T is `temp_nozzle`, T0 the session's first reading. Positive: the tip hangs lower.
struct NozzleTemperature {
  static constexpr std::array<std::string_view, 1> kAxes = {""};
  static constexpr std::array kParameters = {
      Parameter{.name = "growth_um_per_k",
                .unit = "um/K",
                .min = -100,
                .max = 100,
                .prior = Normal{.mean = 0.3, .sd = 0.5},
                .doc = "+: the hot nozzle is longer, its tip hangs lower."},
      Parameter{.name = "lag_s",
                .unit = "s",
                .min = 0,
                .max = 1e6,
                .prior = LogNormal{.median = 120, .factor = 3},
                .doc = "How far it follows behind its thermometer; 0: at once.",
                .role = Role::kForm}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = values[1] = 0;
  }
  static Shown In(std::string_view) {
    return {.channel = "nozzle", .covariates = {"temp"}};
  }
  static Forms Grid(const Machine&, std::string_view, const Extent& extent) {
    return OfOne(Lags_s(extent));
  }
  static constexpr Effect kDeclaration = {
      .name = "nozzle_temperature",
      .about = "The nozzle grows as it is heated.",
      .bucket = Bucket::kTime,
      .stage = Stage::kProbe,
      .parameters = kParameters,
      .formula = "nozzle on switch = ... + k (T_nozzle - T0), lagged",
      .source =
          "Brass 19 and steel 12 um/(m K) over the 15 to 25 mm between heat break and "
          "tip: 0.2 to 0.5 um/K, so 50 to 100 um from cold to 230 degC.",
      .twin =
          "ooze: the same in the touches where it begins to flow; a gap measured under "
          "the nozzle sees ooze, growth it does not.",
      .words =
          {.plot = "Nozzle on the switch against the nozzle's temperature: a line; "
                   "the probe's touches do not follow.",
           .values = "0.2 to 0.5 um per kelvin.",
           .cause = "Nozzle, heater block and heat break expand.",
           .effect =
               "A height set with the nozzle cold presses it 0.05 to 0.1 mm into the "
               "first layer.",
           .action =
               "Calibrate at the nozzle's printing temperature (CALIBRATE_Z takes "
               "growth out), the tip wiped."},
      .neutral = Neutral,
      .sight = Sight{.shown = In, .forms = Grid}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    if (asked.at.climate == nullptr) return;
    errors->nozzle_mm +=
        MmFromUm(asked.p[0]) *
        (*asked.at.climate)[Sensor::kNozzle].Lagged_k(asked.at.t_s, asked.p[1]);
  }
};

}  // namespace caltwin
