#pragma once

#include "sim/base/units.h"
#include "sim/effects/effect.h"
#include "sim/effects/forms.h"

namespace caltwin {

/// The probe triggers later the warmer it is.
///
///   touch = ... - k dT,  lag d(dT)/dt = (T - T0) - dT   [mm]
///
/// T is `temp_screw` (the head's is rarely logged), at a printer's station
/// `temp_chamber`, T0 the session's first reading. The pre-travel grows by k dT along
/// any normal, so it moves opposite faces towards each other; a frame that grows moves
/// both the same way.
struct ProbeTemperature {
  static constexpr std::array<std::string_view, 1> kAxes = {""};
  static constexpr std::array<std::string_view, 1> kAliases = {"z"};
  static constexpr std::array kParameters = {
      Parameter{.name = "drift_um_per_k",
                .unit = "um/K",
                .min = -2000,
                .max = 2000,
                .prior = Normal{.mean = 0, .sd = 2.5},
                .doc = "Growth of the pre-travel per kelvin; +: touches read -."},
      Parameter{.name = "lag_s",
                .unit = "s",
                .min = 0,
                .max = 1e6,
                .prior = LogNormal{.median = 300, .factor = 3},
                .doc = "How far the probe follows behind the thermometer; 0: at once.",
                .role = Role::kForm}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = values[1] = 0;
  }
  static Shown In(std::string_view) {
    return {.channel = "probe", .covariates = {"temp"}};
  }
  static Forms Grid(const Machine&, std::string_view, const Extent& extent) {
    return OfOne(Lags_s(extent));
  }
  static constexpr Effect kDeclaration = {
      .name = "probe_temperature",
      .about = "The probe's trigger point drifts with temperature.",
      .bucket = Bucket::kTime,
      .stage = Stage::kProbe,
      .axes = kAxes,
      .parameters = kParameters,
      .formula = "touch = ... - k (T_screw - T0), lagged",
      .source =
          "Drift of inductive and kinematic probes: 0.5 to 5 um/K; a steel stylus of "
          "50 mm alone makes 0.6 um/K along itself.",
      .twin =
          "frame_temperature: the same on top faces; on faces of both signs (a block "
          "and a bore, top and ledge) the probe's drift changes the size, the frame's "
          "only the place.",
      .words =
          {.plot = "Touches against temperature: all faces fall by the same, whichever "
                   "way they look.",
           .values = "0.5 to 5 um per kelvin.",
           .cause = "Spring, switch or coil of the probe change as the head warms it.",
           .effect = "Bosses measured warm read smaller, bores larger; heights drift.",
           .action =
               "Let the probe reach the head's temperature; measure its deflection "
               "again when the shop has warmed by a few kelvin."},
      .neutral = Neutral,
      .aliases = kAliases,
      .sight = Sight{.shown = In, .forms = Grid}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    if (asked.at.climate == nullptr) return;
    // At a printer's station the probe hangs in the chamber's air.
    const Sensor sensor = asked.at.station ? Sensor::kChamber : Sensor::kScrew;
    errors->more_pretravel_mm +=
        MmFromUm(asked.p[0]) *
        (*asked.at.climate)[sensor].Lagged_k(asked.at.t_s, asked.p[1]);
  }
};

}  // namespace caltwin
