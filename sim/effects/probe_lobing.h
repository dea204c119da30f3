#pragma once

#include "sim/effects/probe_round.h"

namespace caltwin {

/// A probe on three seats needs least deflection towards a seat and most between two.
///
///   more pre-travel = A cos(3 (theta - spindle) + phase)   [mm]
///
/// theta the direction of the outward normal (nx, ny), from +x, counter-clockwise from
/// above; only the horizontal part of a touch feels it.
struct ProbeLobing {
  static constexpr std::array<std::string_view, 1> kAxes = {""};
  static constexpr std::array kParameters = {
      Parameter{.name = "amplitude_um",
                .unit = "um",
                .min = 0,
                .max = 1000,
                .prior = LogNormal{.median = 4, .factor = 3},
                .doc = "Half peak-to-peak of the pre-travel around the circle."},
      Parameter{.name = "phase_deg",
                .unit = "deg",
                .min = -360,
                .max = 360,
                .prior = Uniform{.min = -180, .max = 180},
                .doc = "Of the wave: 0 has a lobe (most pre-travel) on the face that "
                       "looks to +x at spindle 0.",
                .role = Role::kPhase}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = values[1] = 0;
  }
  static Shown ShownIn(std::string_view) {
    return {.channel = "probe", .covariates = {"theta"}};
  }
  static constexpr Effect kDeclaration = {
      .name = "probe_lobing",
      .about = "The probe triggers later in three directions than between them.",
      .bucket = Bucket::kMeasurement,
      .stage = Stage::kProbe,
      .axes = kAxes,
      .parameters = kParameters,
      .formula = "touch = ... - A cos(3 (theta - spindle) + phase)",
      .source =
          "Kinematic resistive probes sit on three balls (ISO 230-10 2D error): "
          "0.5 to 5 um on machine-tool probes, to 20 um with long styli or home-"
          "made seats; strain-gauge probes below 0.5 um.",
      .twin =
          "An out-of-round ring: its lobes stay when the spindle is turned, the "
          "probe's turn along; measure the ring at two spindle orientations.",
      .words = {.plot = "Radius of a ring against direction: three waves around.",
                .values = "Half peak-to-peak: 0.5 to 20 um.",
                .cause = "The seat's geometry: its lever arm is shortest between two "
                         "balls. Stiff springs and long styli make it larger.",
                .effect = "Bores read three-cornered; a span depends on its direction "
                          "though the part does not.",
                .action = "Orient the spindle to the touch so that always the same "
                          "side of the probe works, or calibrate on a ring; use a "
                          "shorter stylus."},
      .neutral = Neutral,
      .sight = Sight{.shown = ShownIn}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    AddLobes(asked, 3, asked.p[0], asked.p[1], errors);
  }
};

}  // namespace caltwin
