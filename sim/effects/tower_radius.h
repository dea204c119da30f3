#pragma once

#include "sim/base/units.h"
#include "sim/effects/knob_turns.h"
#include "sim/machine/kinds/delta/knobs.h"

namespace caltwin {

/// One tower of a delta stands farther out: a reparametrisation of `delta_radius`, the
/// tower angles and a shift of the whole machine, which the baseline holds.
struct TowerRadius {
  static constexpr std::array kParameters = {
      Parameter{.name = "error_mm",
                .unit = "mm",
                .min = -20,
                .max = 20,
                .prior = Normal{.mean = 0, .sd = 0.3},
                .doc = "Farther out than drawn: +; of this tower alone."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
  }
  static Shown In(std::string_view) {
    return {.channel = "z", .covariates = {"x", "y"}};
  }
  static constexpr Effect kDeclaration = {
      .name = "tower_radius",
      .about = "One tower stands farther out than the others.",
      .bucket = Bucket::kMotion,
      .stage = Stage::kFrame,
      .parameters = kParameters,
      .formula = "tower joint at (radius + error) (cos, sin)",
      .source = "Frames cut by hand: 0.1 to 1 mm.",
      .twin =
          "delta_radius and tower angles: three points always lie on a circle, so "
          "radii of their own are only another way to write radius, angles and a "
          "shift. Nothing tells them apart, and nothing needs to.",
      .words =
          {.plot =
               "Error in z against position: gone once radius and angles are fitted.",
           .values = "0.1 to 1 mm.",
           .cause = "A side of the frame longer than the others.",
           .effect = "None that delta_radius and the tower angles do not take up.",
           .action = "Calibrate radius and angles."},
      .neutral = Neutral,
      .sight = Sight{.shown = In}};

  template <typename T>
  static std::array<KnobTurn<T>, 3> Turns(std::string_view axis, std::span<const T> p) {
    const int tower = TowerIndex(axis);
    if (tower < 2) return {{{kTowerRadiusKnob + tower, p[0]}, {}, {}}};
    // Of tower c: all three, less a and b.
    return {{{kRadiusKnob, p[0]},
             {kTowerRadiusKnob, T(-p[0])},
             {kTowerRadiusKnob + 1, T(-p[0])}}};
  }
  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    AddTurns(asked, Turns(asked.axis, asked.p), errors);
  }
};

}  // namespace caltwin
