#pragma once

#include "sim/base/units.h"
#include "sim/effects/effect.h"

namespace caltwin {

/// Each trigger comes at a slightly different deflection: normal, independent.
///
/// No mean error; its variance adds to that of a touch.
struct TriggerScatter {
  static constexpr std::array<std::string_view, 1> kAxes = {""};
  static constexpr std::array kParameters = {
      Parameter{.name = "sd_um",
                .unit = "um",
                .min = 0,
                .max = 1000,
                .prior = LogNormal{.median = 1, .factor = 3},
                .doc = "Standard deviation of one trigger along the normal."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
  }
  static constexpr Effect kDeclaration = {
      .name = "trigger_scatter",
      .about = "The probe does not trigger at the same deflection every time.",
      .bucket = Bucket::kMeasurement,
      .stage = Stage::kReadout,
      .axes = kAxes,
      .parameters = kParameters,
      .formula = "touch = ... + N(0, sd)",
      .source =
          "Unidirectional repeatability of touch probes, ISO 230-10: 0.3 to 5 um.",
      .twin =
          "homing_scatter: alike within one homing; touches repeated without homing "
          "tell.",
      .words = {.plot = "Repeats of one touch: a cloud without trend.",
                .values = "Its standard deviation: 0.3 to 5 um.",
                .cause = "Contact bounce, cable, dirt on the ball or the face.",
                .effect = "Calibration scatters; more touches average it.",
                .action =
                    "Clean ball and face, slow the measuring touch, repeat more."},
      .neutral = Neutral};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    const T sd_mm = MmFromUm(asked.p[0]);
    errors->scatter_mm2 += sd_mm * sd_mm;
  }
};

}  // namespace caltwin
