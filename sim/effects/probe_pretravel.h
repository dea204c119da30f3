#pragma once

#include "sim/effects/effect.h"

namespace caltwin {

/// The stylus bends by the pre-travel before the probe triggers; per axis and sense.
///
/// Axis "x": both senses; "x+": pushed by a machine that moves in +x (a face that looks
/// towards -x); "x-" the other. Between the axes the switch opens when
///
///   (d_x / p_x)^2 + (d_y / p_y)^2 + (d_z / p_z)^2 = 1,
///
/// d the deflection, p the pre-travel of that axis and sense, so along a normal n the
/// pre-travel is 1 / sqrt(sum (n_i / p_i)^2): Pretravel_mm in predict.h.
struct ProbePretravel {
  static constexpr std::array<std::string_view, 9> kAxes = {
      "x", "y", "z", "x+", "x-", "y+", "y-", "z+", "z-"};
  static constexpr std::array kParameters = {Parameter{
      .name = "pretravel_mm",
      .unit = "mm",
      .min = 0.001,
      .max = 2,
      .prior = LogNormal{.median = 0.02, .factor = 2},
      .doc = "Deflection of the tip at the trigger; replaces the drawing's."}};
  static void Neutral(const Machine& machine,
                      std::string_view,
                      std::span<double> values) {
    values[0] = machine.probe.pretravel_mm;
  }
  static constexpr Effect kDeclaration = {
      .name = "probe_pretravel",
      .about = "The machine moves on after contact until the probe triggers.",
      .bucket = Bucket::kMeasurement,
      .stage = Stage::kProbe,
      .axes = kAxes,
      .parameters = kParameters,
      .formula = "touch = ... - p(n),  p(n) = 1 / sqrt(sum (n_i / p_i)^2)",
      .source =
          "Kinematic resistive probes, ISO 230-10: 5 to 50 um at the stylus tip, "
          "more on long styli.",
      .twin = "backlash, tip_size: spans see pre-travel + b/2 - R only.",
      .words = {.plot = "Every boss reads small and every bore large, by the same.",
                .values = "5 to 50 um, alike at every position.",
                .cause = "The stylus bends and its seat tips before the contact opens.",
                .effect = "Sizes measured from inside and outside disagree.",
                .action = "Enter it as the probe's deflection, one value an axis."},
      .neutral = Neutral};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    auto& both =
        errors->pretravel_mm[Index(AxisNamed(asked.axis.substr(0, 1)).value())];
    const bool plus = !asked.axis.ends_with('-');
    const bool minus = !asked.axis.ends_with('+');
    if (plus) both[0] = asked.p[0];
    if (minus) both[1] = asked.p[0];
  }
};

}  // namespace caltwin
