#pragma once

#include <cmath>

#include "sim/base/units.h"
#include "sim/effects/effect.h"

namespace caltwin {

/// Two axes do not meet at 90 degrees: the second is turned about the third.
///
///   C0Y: dx = -sin(a) u, dy = (cos(a) - 1) u,  u = y - mid travel
///   B0Z: dx = +sin(a) u, dz = (cos(a) - 1) u,  u = z - mid travel
///   A0Z: dy = -sin(a) u, dz = (cos(a) - 1) u   [mm]
///
/// Right-handed about the letter's axis (ISO 230-1): C0Y > 0 turns Y counter-clockwise
/// seen from above.
struct Squareness {
  static constexpr std::array<std::string_view, 3> kAxes = {"C0Y", "B0Z", "A0Z"};
  static constexpr std::array kParameters = {
      Parameter{.name = "angle_mrad",
                .unit = "mrad",
                .min = -50,
                .max = 50,
                .prior = Normal{.mean = 0, .sd = 1.5},
                .doc = "Right-handed about the axis of the first letter."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
  }
  static Shown In(std::string_view axis) {
    return {.channel = axis == "A0Z" ? "y" : "x",
            .covariates = {axis == "C0Y" ? "y" : "z"}};
  }
  static constexpr Effect kDeclaration = {
      .name = "squareness",
      .about = "Two axes do not meet at a right angle.",
      .bucket = Bucket::kMotion,
      .stage = Stage::kFrame,
      .axes = kAxes,
      .parameters = kParameters,
      .formula = "C0Y: dx = -a y;  B0Z: dx = +a z;  A0Z: dy = -a z",
      .source = "ISO 230-1 names; gantries squared by hand: 0.2 to 2 mrad.",
      .twin =
          "block_rotated: one face cannot tell; an artefact turned by 90 degrees "
          "does.",
      .words = {.plot = "Position across against position along: a line.",
                .values = "Its slope: 5 to 2000 um per metre.",
                .cause = "Gantry not square to its rails, spindle not trammed.",
                .effect = "Rectangles become parallelograms; diagonals differ.",
                .action = "Square the gantry; M556 where the firmware has it."},
      .neutral = Neutral,
      .sight = Sight{.shown = In}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    using std::cos;
    using std::sin;
    const T angle_rad = RadFromMrad(asked.p[0]);
    const Axis turned = asked.axis == "C0Y" ? Axis::kY : Axis::kZ;
    const Axis across = asked.axis == "A0Z" ? Axis::kY : Axis::kX;
    const double sign = asked.axis == "B0Z" ? 1.0 : -1.0;
    const T along_mm = asked.q_mm[Index(turned)] - asked.machine.axis(turned).mid_mm();
    errors->motion_mm[Index(across)] += sign * sin(angle_rad) * along_mm;
    errors->motion_mm[Index(turned)] += (cos(angle_rad) - 1.0) * along_mm;
  }
};

}  // namespace caltwin
