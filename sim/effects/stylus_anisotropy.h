#pragma once

#include "sim/effects/probe_round.h"

namespace caltwin {

/// The stylus bends more easily along one diameter than across it.
///
///   more pre-travel = A cos(2 (theta - spindle) + phase)   [mm]
///
/// theta as for probe_lobing; the same for opposite faces.
struct StylusAnisotropy {
  static constexpr std::array<std::string_view, 1> kAxes = {""};
  static constexpr std::array kParameters = {
      Parameter{.name = "amplitude_um",
                .unit = "um",
                .min = 0,
                .max = 1000,
                .prior = LogNormal{.median = 3, .factor = 2.5},
                .doc = "Half peak-to-peak of the pre-travel around the circle."},
      Parameter{.name = "phase_deg",
                .unit = "deg",
                .min = -360,
                .max = 360,
                .prior = Uniform{.min = -180, .max = 180},
                .doc = "Of the wave: 0 has the most pre-travel along x at spindle 0.",
                .role = Role::kPhase}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = values[1] = 0;
  }
  static Shown ShownIn(std::string_view) {
    return {.channel = "probe", .covariates = {"theta"}};
  }
  static constexpr Effect kDeclaration = {
      .name = "stylus_anisotropy",
      .about = "The stylus is softer along one diameter than across it.",
      .bucket = Bucket::kMeasurement,
      .stage = Stage::kProbe,
      .axes = kAxes,
      .parameters = kParameters,
      .formula = "touch = ... - A cos(2 (theta - spindle) + phase)",
      .source =
          "Styli with a flat, a joint or a cross piece; leaf-sprung probes: 1 to "
          "10 um between the two directions.",
      .twin =
          "backlash of X against Y, or an oval ring: both stay when the spindle is "
          "turned by 90 degrees; this changes its sign.",
      .words = {.plot = "Radius of a ring against direction: an ellipse that turns "
                        "with the spindle.",
                .values = "Half peak-to-peak: 1 to 10 um.",
                .cause = "A bent or flattened stem, a loose joint, unequal springs.",
                .effect = "Bores read oval; spans along x and y disagree.",
                .action = "Change the stylus; else keep one deflection setting an "
                          "axis, and orient the spindle always alike."},
      .neutral = Neutral,
      .sight = Sight{.shown = ShownIn}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    AddLobes(asked, 2, asked.p[0], asked.p[1], errors);
  }
};

}  // namespace caltwin
