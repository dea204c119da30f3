#pragma once

#include "sim/effects/drive.h"
#include "sim/effects/effect.h"

namespace caltwin {

/// A bed held by more than six constraints: guides that want it level beside three
/// screws that want it tilted. What gives is the screws' supports: all three bend until
/// forces balance.
///
///   h = turning stiffness of the guides / axial stiffness of a screw's support, mm^2
///   K = sum d_i d_i^T,  d_i from the screws' middle to screw i
///   tilt = (K + h)^-1 sum d_i z_i,  the middle stands at the mean of z_i
///
/// h = 0: the plane through the screws (six constraints). From the least elastic energy
/// k/2 sum (bed_i - z_i)^2 + h k/2 |tilt|^2; the bed itself is rigid (WeightsHeldBack).
struct OverconstrainedBed {
  static constexpr std::array<std::string_view, 1> kAxes = {""};
  static constexpr std::array kParameters = {
      Parameter{.name = "stiffness_ratio_mm2",
                .unit = "mm^2",
                .min = 0,
                .max = 20000,
                .prior = LogNormal{.median = 500, .factor = 3},
                .doc = "Turning stiffness of the guides (N mm per rad) over axial "
                       "stiffness of one screw's support (N per mm)."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
  }
  static Shown In(std::string_view) {
    return {.channel = "z", .covariates = {"x", "y", "motor_a", "motor_b", "motor_c"}};
  }
  static constexpr Effect kDeclaration = {
      .name = "overconstrained_bed",
      .about =
          "Guides hold the bed level against screws that give, so that it follows "
          "only a part of a tilt.",
      .bucket = Bucket::kMotion,
      .stage = Stage::kDrive,
      .parameters = kParameters,
      .formula =
          "tilt = (K + h)^-1 sum d_i z_i, K = sum d_i d_i^T, d_i from the screws' "
          "middle; the middle at the mean of z_i",
      .source =
          "Derived: least elastic energy of a rigid bed. Size: two 8 mm rods in ball "
          "bushings turn by 1 mrad under about 0.25 N m, a screw's bracket gives 1 mm "
          "under about 500 N: 500 mm^2; rails bolted to the bed reach ten times that.",
      .twin =
          "pivot_position of all three screws at once, each further from their middle: "
          "the same for every touch; a single screw out of place is not.",
      .words = {.plot = "Height over a screw that is raised alone: it follows by less "
                        "than it is told, and the others, which stand, move too.",
                .values = "100 to 5000 mm^2: 1 to 30 percent of a tilt is lost.",
                .cause = "Nuts bolted to the bed without joints, or guides that leave "
                         "it no freedom to tilt.",
                .effect = "Each levelling round leaves that part of the tilt; screws "
                          "and guides are strained and wear.",
                .action = "Give two of three screws a joint (ball in groove, ball on "
                          "flat), or loosen the guides while levelling."},
      .neutral = Neutral,
      .sight = Sight{.shown = In}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    errors->held_mm2 += asked.p[0];
  }
};

}  // namespace caltwin
