#pragma once

#include "sim/base/units.h"
#include "sim/effects/carriages.h"

namespace caltwin {

/// A rail is bowed: the tool leaves the straight line across its motion.
///
///   EYX: dy = bow (U_x^2 - 1/3),  U = -1 .. 1 over the travel   [mm]
///
/// and so on for the others: the second letter errs as the third moves. Positive: both
/// ends go to + against the middle; peak to valley over the travel. EZX is gantry_sag.
/// A line across the motion is squareness, so the bow has none.
struct Straightness {
  static constexpr std::array<std::string_view, 5> kAxes = {
      "EYX", "EXY", "EZY", "EXZ", "EYZ"};
  /// A bed is touched along z alone.
  static constexpr std::array<std::string_view, 1> kTripleZAxes = {"EZY"};
  static constexpr std::array kParameters = {
      Parameter{.name = "bow_um",
                .unit = "um",
                .min = -5000,
                .max = 5000,
                .prior = Normal{.mean = 0, .sd = 20},
                .doc = "Peak to valley over the whole travel; +: both ends go to + "
                       "against the middle."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
  }
  static Axis Across(std::string_view axis) {
    return caltwin::kAxes[static_cast<std::size_t>(axis[1] - 'X')];
  }
  static Shown ShownIn(std::string_view axis) {
    return {.channel = Name(Across(axis)), .covariates = {Name(MovingAxis(axis))}};
  }
  static constexpr Effect kDeclaration = {
      .name = "straightness",
      .about = "A rail is bowed: the tool leaves the straight line across its motion.",
      .bucket = Bucket::kMotion,
      .stage = Stage::kFrame,
      .axes = kAxes,
      .parameters = kParameters,
      .formula = "EYX: dy = bow (U_x^2 - 1/3), U = -1 .. 1 over the travel",
      .source =
          "ISO 230-1, names and definition. Ground profile rails bolted to a "
          "milled face: 5 to 20 um over 300 mm; to an extrusion as bought: 50 um "
          "and more; a machined casting: 2 to 5 um.",
      .twin =
          "A straight-edge that is not straight: measure on both of its sides; the "
          "machine's bow keeps its sign, the straight-edge's changes it.",
      .words = {.plot = "Error across against position along: a parabola, its ends on "
                        "the same side of its middle.",
                .values = "Its height, ends to middle: 2 to 50 um over the travel.",
                .cause = "Rail bolted to a bent beam, one screw overtightened, or a "
                         "beam that bends under the carriage's weight.",
                .effect = "Long edges come out bowed by as much; two halves of a part "
                          "do not close.",
                .action = "Measure against a straight-edge on both of its sides, then "
                          "shim or scrape the rail; firmware seldom corrects it."},
      .neutral = Neutral,
      .sight = Sight{.shown = ShownIn}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    const Axis moving = MovingAxis(asked.axis);
    errors->motion_mm[Index(Across(asked.axis))] +=
        MmFromUm(asked.p[0]) * Bow(asked.machine, moving, asked.q_mm[Index(moving)]);
  }
};

}  // namespace caltwin
