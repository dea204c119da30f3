#pragma once

#include "sim/base/units.h"
#include "sim/effects/knob_turns.h"

namespace caltwin {

/// A delta's tower leans, about the point where it meets the plane of the bed.
///
///   carriage at height h: displaced by h (radial e_r + tangential e_t)   [mm]
///
/// e_r outward, e_t counter-clockwise seen from above. The nozzle follows through the
/// closed chain.
struct TowerLean {
  static constexpr std::array kParameters = {
      Parameter{.name = "radial_mrad",
                .unit = "mrad",
                .min = -50,
                .max = 50,
                .prior = Normal{.mean = 0, .sd = 2},
                .doc = "+: the top goes outward; about the height of the bed."},
      Parameter{.name = "tangential_mrad",
                .unit = "mrad",
                .min = -50,
                .max = 50,
                .prior = Normal{.mean = 0, .sd = 2},
                .doc = "+: the top goes counter-clockwise."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = values[1] = 0;
  }
  static Shown In(std::string_view) {
    return {.channel = "z", .covariates = {"x", "y"}};
  }
  static constexpr Effect kDeclaration = {
      .name = "tower_lean",
      .about =
          "A tower does not stand upright, so its carriage moves sideways as it rises.",
      .bucket = Bucket::kMotion,
      .stage = Stage::kFrame,
      .parameters = kParameters,
      .formula =
          "carriage at height h is displaced by h (radial e_r + tangential e_t) in the "
          "plane",
      .source =
          "Frames bolted from extrusions: 1 to 5 mrad, i.e. 0.5 to 2.5 mm over 500 mm.",
      .twin =
          "belt_pitch, where only heights are measured: both grow along the tower. "
          "Measure along x and y too, and at several heights.",
      .words = {.plot = "Error in z and in the plane against position: it grows away "
                        "from that tower, and with height.",
                .values = "1 to 5 mrad; 1 mrad moves the joint by 0.3 mm at 300 mm.",
                .cause = "Corner brackets out of square, a frame that was twisted when "
                         "it was bolted.",
                .effect = "Parts lean and their size depends on the height; no "
                          "firmware has a number for it.",
                .action = "Square the tower against the bed, brace the frame, then "
                          "calibrate again."},
      .neutral = Neutral,
      .sight = Sight{.shown = In}};

  template <typename T>
  static std::array<KnobTurn<T>, 2> Turns(std::string_view axis, std::span<const T> p) {
    return {{{kLeanRadialKnob + TowerIndex(axis), RadFromMrad(p[0])},
             {kLeanTangentialKnob + TowerIndex(axis), RadFromMrad(p[1])}}};
  }
  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    AddTurns(asked, Turns(asked.axis, asked.p), errors);
  }
};

}  // namespace caltwin
