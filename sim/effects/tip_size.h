#pragma once

#include "sim/effects/effect.h"

namespace caltwin {

/// The ball's true radius differs from the drawing's.
///
///   touch = ... + (R_true - R_cfg)   [mm]
struct TipSize {
  static constexpr std::array<std::string_view, 1> kAxes = {""};
  static constexpr std::array kParameters = {
      Parameter{.name = "radius_error_mm",
                .unit = "mm",
                .min = -5,
                .max = 5,
                .prior = Normal{.mean = 0, .sd = 0.01},
                .doc = "True radius minus drawn radius."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
  }
  /// The same on every face: it depends on nothing.
  static Shown In(std::string_view) { return {.channel = "probe"}; }
  static constexpr Effect kDeclaration = {
      .name = "tip_size",
      .about = "The probe's ball is not the size that was entered.",
      .bucket = Bucket::kMeasurement,
      .stage = Stage::kProbe,
      .axes = kAxes,
      .parameters = kParameters,
      .formula = "touch = ... + (R_true - R_cfg)",
      .source = "Ruby balls are within 1 um; diameter entered as radius errs by 1 mm.",
      .twin =
          "probe_pretravel: no span and no bore tells it; its size does, or a "
          "calliper on the ball.",
      .words = {.plot = "All bosses read large and all bores small, by the same.",
                .values = "Micrometres, or millimetres where a diameter was entered.",
                .cause = "Wrong entry, another stylus fitted, a worn ball.",
                .effect = "Every face is off by the difference.",
                .action = "Measure the ball with a calliper; enter its radius."},
      .neutral = Neutral,
      .sight = Sight{.shown = In}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    errors->tip_radius_mm += asked.p[0];
  }
};

}  // namespace caltwin
