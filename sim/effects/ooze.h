#pragma once

#include "sim/base/units.h"
#include "sim/effects/effect.h"
#include "sim/effects/forms.h"

namespace caltwin {

/// Plastic hangs under the nozzle once it is hot enough to flow: it meets the switch
/// before the nozzle does.
///
///   nozzle on switch = ... + ooze,  gap after calibration = ... + ooze,
///   where T_nozzle >= flows, but for a nozzle that was wiped just before   [mm]
///
/// Plastic that is there whatever the temperature (flows at 0) looks like a wrong
/// switch_offset in every reading: only a wiped nozzle tells.
struct Ooze {
  static constexpr std::array<std::string_view, 1> kAxes = {""};
  static constexpr std::array kParameters = {
      Parameter{.name = "thickness_um",
                .unit = "um",
                .min = 0,
                .max = 5000,
                .prior = LogNormal{.median = 80, .factor = 2.5},
                .doc = "Under the tip, as the switch squashes it."},
      Parameter{.name = "flows_c",
                .unit = "degC",
                .min = 0,
                .max = 400,
                .prior = Uniform{.min = 100, .max = 260},
                .doc = "Nozzle temperature from which there is some; 0: always.",
                .role = Role::kForm}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
    values[1] = 170;
  }
  static Shown In(std::string_view) {
    return {.channel = "nozzle", .covariates = {"temp"}};
  }
  static Forms Grid(const Machine&, std::string_view, const Extent&) {
    return OfOne({0, 60, 100, 130, 160, 180, 200, 220, 245});
  }
  static constexpr Effect kDeclaration = {
      .name = "ooze",
      .about = "Plastic under the hot nozzle meets the switch before the nozzle does.",
      .bucket = Bucket::kMeasurement,
      .stage = Stage::kProbe,
      .parameters = kParameters,
      .formula =
          "nozzle on switch, and the gap after calibration: + thickness where "
          "T_nozzle >= flows, unless it was wiped just before",
      .source =
          "Drops and strings of PLA, PETG and ABS on brass nozzles: 0.05 to 0.5 mm; "
          "they flow from 150 to 200 degC.",
      .twin =
          "nozzle_temperature: growth begins with the first kelvin and does not show "
          "in "
          "the gap. switch_offset: the same in the gap, also where the nozzle was "
          "wiped.",
      .words = {.plot =
                    "Nozzle on the switch against the nozzle's temperature: a step.",
                .values = "0.05 to 0.5 mm.",
                .cause = "The nozzle touches the switch with plastic on its tip.",
                .effect = "The clean nozzle prints that much too high.",
                .action =
                    "Wipe the nozzle in start_gcode, or touch the switch below the "
                    "temperature at which it flows."},
      .neutral = Neutral,
      .sight = Sight{.shown = In, .forms = Grid, .shows_at_rest = true}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    if (asked.at.climate == nullptr || asked.at.is_wiped) return;
    const TemperatureLog& log = (*asked.at.climate)[Sensor::kNozzle];
    if (log.empty()) return;
    const double temp_c = log.first_c() + log.At_k(asked.at.t_s);
    if (asked.p[1] <= temp_c) errors->ooze_mm += MmFromUm(asked.p[0]);
  }
};

}  // namespace caltwin
