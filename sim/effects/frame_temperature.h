#pragma once

#include "sim/base/units.h"
#include "sim/effects/effect.h"
#include "sim/effects/forms.h"

namespace caltwin {

/// Frame or bed grow with their own temperature, along z.
///
///   frame: dz of the tool   = k dT_frame   (touches on top read -)
///   bed:   dz of the surface = k dT_bed     (touches on top read +)   [mm]
///   lag d(dT)/dt = (T - T0) - dT,  T0 the session's first reading
///
/// The bed raises what stands on it; what does not is left where it is.
struct FrameTemperature {
  static constexpr std::array<std::string_view, 2> kAxes = {"frame", "bed"};
  static constexpr std::array kParameters = {
      Parameter{.name = "growth_um_per_k",
                .unit = "um/K",
                .min = -2000,
                .max = 2000,
                .prior = Normal{.mean = 0, .sd = 15},
                .doc = "Frame +: lifts the tool; bed +: raises what stands on it."},
      Parameter{.name = "lag_s",
                .unit = "s",
                .min = 0,
                .max = 1e6,
                .prior = LogNormal{.median = 600, .factor = 3},
                .doc = "How far the part follows behind its thermometer; 0: at once.",
                .role = Role::kForm}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = values[1] = 0;
  }
  static Shown In(std::string_view axis) {
    return {.channel = axis == "bed" ? "bed" : "z", .covariates = {"temp"}};
  }
  static Forms Grid(const Machine&, std::string_view, const Extent& extent) {
    return OfOne(Lags_s(extent));
  }
  static constexpr Effect kDeclaration = {
      .name = "frame_temperature",
      .about = "Frame or bed grow with their temperature, so the height drifts.",
      .bucket = Bucket::kTime,
      .stage = Stage::kFrame,
      .axes = kAxes,
      .parameters = kParameters,
      .formula =
          "frame: tool rises by k (T_frame - T0); bed: surface rises by k (T_bed - "
          "T0); lagged",
      .source =
          "Aluminium 23 and steel 11.5 um/(m K): 400 mm of aluminium make 9 um/K; "
          "enclosed printers with bent gantries reach 30 um/K, heated beds 1 to 5.",
      .twin =
          "frame against bed: alike while both warm together; both temperatures "
          "logged, "
          "through warming and cooling, tell. frame_growth: time instead of "
          "temperature.",
      .words =
          {.plot = "Height of one datum against the part's temperature: a line, or a "
                   "loop where it lags.",
           .values = "1 to 50 um per kelvin; lags of minutes to an hour.",
           .cause =
               "Frame, gantry or bed expand; two metals bolted together also bend.",
           .effect =
               "Heights and first layers drift as the enclosure or the shop warms.",
           .action = "Wait until temperatures stand still; probe the height at working "
                     "temperature; enter the frame's where the firmware corrects it "
                     "(Klipper: z_thermal_adjust, temp_coeff in mm/K, the same sign)."},
      .neutral = Neutral,
      .sight = Sight{.shown = In, .forms = Grid}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    if (asked.at.climate == nullptr) return;
    const bool is_bed = asked.axis == "bed";
    if (is_bed && !asked.at.on_table) return;
    const Sensor sensor = is_bed ? Sensor::kBed : Sensor::kFrame;
    const T rise_mm = MmFromUm(asked.p[0]) *
                      (*asked.at.climate)[sensor].Lagged_k(asked.at.t_s, asked.p[1]);
    if (is_bed) {
      errors->artefact_mm += asked.at.n[2] * rise_mm;
    } else {
      errors->motion_mm[2] += rise_mm;
    }
  }
};

}  // namespace caltwin
