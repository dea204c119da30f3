#pragma once

#include "sim/base/units.h"
#include "sim/effects/knob_turns.h"

namespace caltwin {

/// A delta's tower is turned about its own axis: the two joints of its carriage turn
/// about the carriage's middle by `angle_deg`, counter-clockwise seen from above.
struct TowerTwist {
  static constexpr std::array kParameters = {
      Parameter{.name = "angle_deg",
                .unit = "deg",
                .min = -10,
                .max = 10,
                .prior = Normal{.mean = 0, .sd = 0.5},
                .doc = "+: counter-clockwise from above."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
  }
  static Shown In(std::string_view) {
    return {.channel = "z", .covariates = {"x", "y"}};
  }
  static constexpr Effect kDeclaration = {
      .name = "tower_twist",
      .about = "A tower is turned about its own axis, and its carriage with it.",
      .bucket = Bucket::kMotion,
      .stage = Stage::kFrame,
      .parameters = kParameters,
      .formula =
          "the two joints of the carriage turn by the angle about the carriage's "
          "middle",
      .source = "Extrusions screwed through one slot: 0.1 to 1 deg.",
      .twin =
          "rod_mismatch: the two rods of that tower change length apart. Measure in "
          "the plane and in z.",
      .words =
          {.plot = "Error in z against position: a twist of the surface, the effector "
                   "tilting as it moves sideways.",
           .values =
               "0.1 to 1 deg; 1 deg with rods 40 mm apart moves each joint by 0.35 mm.",
           .cause = "Tower clamped askew, a carriage whose arms stand unevenly.",
           .effect = "The effector tilts as it moves, the more the farther its nozzle "
                     "hangs below the joints.",
           .action = "Loosen the tower, turn it until its face is square to the middle "
                     "of the bed."},
      .neutral = Neutral,
      .sight = Sight{.shown = In}};

  template <typename T>
  static std::array<KnobTurn<T>, 1> Turns(std::string_view axis, std::span<const T> p) {
    return {{{kTwistKnob + TowerIndex(axis), RadFromDeg(p[0])}}};
  }
  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    AddTurns(asked, Turns(asked.axis, asked.p), errors);
  }
};

}  // namespace caltwin
