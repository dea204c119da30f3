#pragma once

#include <cmath>

#include "sim/base/units.h"
#include "sim/effects/effect.h"

namespace caltwin {

/// The beam of a CoreXY, or of a gantry with a motor at each end of it, does not stand
/// square to its rails: one end is ahead of the other.
///
///   dx = (cos(a) - 1) u,  dy = sin(a) u,  u = x - mid travel   [mm]
///
/// Right-handed about z: a > 0 turns the beam counter-clockwise seen from above. Beside
/// a whole that may be turned it is a squareness C0Y of -a.
struct Racking {
  static constexpr std::array kParameters = {
      Parameter{.name = "angle_mrad",
                .unit = "mrad",
                .min = -50,
                .max = 50,
                .prior = Normal{.mean = 0, .sd = 2},
                .doc = "+: the beam is turned counter-clockwise, seen from above."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
  }
  static Shown In(std::string_view) { return {.channel = "y", .covariates = {"x"}}; }
  static constexpr Effect kDeclaration = {
      .name = "racking",
      .about =
          "The beam of a CoreXY, or of a gantry with two motors, does not stand "
          "square to its rails.",
      .bucket = Bucket::kMotion,
      .stage = Stage::kFrame,
      .parameters = kParameters,
      .formula = "dy = a (x - middle)",
      .source =
          "Geometry; size: a beam squared by eye is off by 0.2 to 1 mm at the end of "
          "350 mm. No survey of machines is known to this project.",
      .twin =
          "squareness.C0Y and one belt of another pitch: all three turn a square into "
          "the same parallelogram. A square against the rails tells the beam; the size "
          "of parts tells a belt's pitch.",
      .words = {.plot = "y against x, of a straight line along x: a slope.",
                .values = "0.5 to 3 mrad; 1 mrad is 0.3 mm over a beam of 300 mm.",
                .cause =
                    "Belts of unlike tension or length, a beam clamped askew; of two "
                    "motors, home switches that stand unevenly.",
                .effect = "Squares become parallelograms; diagonals differ.",
                .action =
                    "Loosen the beam, square it against the front, tension both belts "
                    "to the same tone, tighten; of two motors set the second one's "
                    "home offset; what is left: skew correction."},
      .neutral = Neutral,
      .sight = Sight{.shown = In}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    using std::cos;
    using std::sin;
    const T angle_rad = RadFromMrad(asked.p[0]);
    const T along_mm = asked.q_mm[0] - asked.machine.axis(Axis::kX).mid_mm();
    errors->motion_mm[0] += (cos(angle_rad) - 1.0) * along_mm;
    errors->motion_mm[1] += sin(angle_rad) * along_mm;
  }
};

}  // namespace caltwin
