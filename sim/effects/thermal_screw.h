#pragma once

#include "sim/base/units.h"
#include "sim/effects/effect.h"
#include "sim/effects/forms.h"

namespace caltwin {

/// A warm screw is longer: everything moves away from its fixed end.
///
///   actual - commanded = alpha (q - q_home) dT,  lag d(dT)/dt = (T - T0) - dT   [mm]
///
/// T is `temp_screw`, T0 the session's first reading, alpha in um per metre and kelvin
/// (ppm/K). The fixed bearing is taken to be at the home end: one at the other end adds
/// a constant, which the next homing takes off. Positive: a warmer axis moves too far.
struct ThermalScrew {
  static constexpr std::array<std::string_view, 3> kAxes = {"x", "y", "z"};
  static constexpr std::array kParameters = {
      Parameter{.name = "expansion_um_per_m_k",
                .unit = "um/(m K)",
                .min = -2000,
                .max = 2000,
                .prior = Normal{.mean = 11.5, .sd = 8},
                .doc = "Growth per metre from the home end and kelvin; steel: 11.5."},
      Parameter{.name = "lag_s",
                .unit = "s",
                .min = 0,
                .max = 1e6,
                .prior = LogNormal{.median = 300, .factor = 3},
                .doc = "How far the screw follows behind its thermometer; 0: at once.",
                .role = Role::kForm}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = values[1] = 0;
  }
  static Shown In(std::string_view axis) {
    return {.channel = std::string(axis), .covariates = {"temp", std::string(axis)}};
  }
  static Forms Grid(const Machine&, std::string_view, const Extent& extent) {
    return OfOne(Lags_s(extent));
  }
  static constexpr Effect kDeclaration = {
      .name = "thermal_screw",
      .about = "The screw grows as it warms, so the axis moves too far.",
      .bucket = Bucket::kTime,
      .stage = Stage::kDrive,
      .axes = kAxes,
      .parameters = kParameters,
      .formula = "actual - commanded = alpha (q - q_home) (T_screw - T0), lagged",
      .source =
          "Expansion of steel: 11.5 um/(m K), trapezoidal and ball screws alike; "
          "ISO 230-3 for the test; screws in use warm by 2 to 15 K.",
      .twin =
          "steps_per_mm: the same at one temperature; a run from cold, with positions "
          "far apart, tells. An artefact that warms looks the same: log its "
          "temperature too.",
      .words =
          {.plot =
               "Error against temperature: a fan of lines, steeper the farther from "
               "home.",
           .values =
               "11.5 um per metre and kelvin for steel; 300 mm and 10 K make 35 um.",
           .cause = "The nut's friction and the motor warm the screw.",
           .effect = "Parts grow during the first hour; cold and warm sizes differ.",
           .action =
               "Warm up before measuring and cutting; measure scale at working "
               "temperature; correct steps/mm by the growth found, 1 um/(m K) being "
               "1 ppm per kelvin."},
      .neutral = Neutral,
      .sight = Sight{.shown = In, .forms = Grid}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    if (asked.at.climate == nullptr) return;
    const Axis axis = AxisNamed(asked.axis).value();
    const int i = Index(axis);
    const T from_home_mm = asked.q_mm[i] - asked.machine.axis(axis).home_mm();
    const T warmer_k =
        (*asked.at.climate)[Sensor::kScrew].Lagged_k(asked.at.t_s, asked.p[1]);
    errors->motion_mm[i] += FractionFromPpm(asked.p[0]) * from_home_mm * warmer_k;
  }
};

}  // namespace caltwin
