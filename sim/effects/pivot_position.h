#pragma once

#include "sim/effects/drive.h"
#include "sim/effects/effect.h"
#include "sim/machine/kinds/triple_z/drawing.h"

namespace caltwin {

/// A screw under the bed does not stand where the drawing (and the firmware) has it.
///
///   bed(x, y) = sum w_i(x, y) z_i,  w_i of the triangle as built   [mm]
///
/// Nothing shows while all screws stand alike: only moves of single screws tell. Exact
/// in dx and dy (MotionOfMotors_mm).
struct PivotPosition {
  static constexpr std::array kParameters = {
      Parameter{.name = "dx_mm",
                .unit = "mm",
                .min = -200,
                .max = 200,
                .prior = Normal{.mean = 0, .sd = 10},
                .doc = "Built less drawn, along x."},
      Parameter{.name = "dy_mm",
                .unit = "mm",
                .min = -200,
                .max = 200,
                .prior = Normal{.mean = 0, .sd = 10},
                .doc = "Built less drawn, along y."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = values[1] = 0;
  }
  static Shown In(std::string_view) {
    return {.channel = "z", .covariates = {"x", "y"}};
  }
  static constexpr Effect kDeclaration = {
      .name = "pivot_position",
      .about = "A screw under the bed stands elsewhere than the firmware believes.",
      .bucket = Bucket::kMotion,
      .stage = Stage::kDrive,
      .parameters = kParameters,
      .formula = "bed(x, y) = sum w_i z_i, w_i of the triangle of screws as built",
      .source =
          "Numbers copied from another machine's file (M671, z_positions), measured to "
          "the bed's edge, or left and right exchanged: 5 to 100 mm.",
      .twin =
          "screw_pitch: both tilt the bed as a screw moves alone; pitch also does "
          "when all move.",
      .words = {.plot =
                    "Change of height when one screw moves, over the bed: a plane that "
                    "does not meet the others' pivots where it should.",
                .values = "Millimetres to centimetres.",
                .cause = "Pivots entered for the wrong origin, order or machine.",
                .effect =
                    "Levelling needs several rounds, each leaving the pivot error's "
                    "share; far off it diverges.",
                .action = "Enter the positions found (M671 X Y, z_positions)."},
      .neutral = Neutral,
      .sight = Sight{.shown = In}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    const auto screw = static_cast<Eigen::Index>(DriveNamed(asked.axis)->index);
    errors->pivot_off_mm(0, screw) += asked.p[0];
    errors->pivot_off_mm(1, screw) += asked.p[1];
  }
};

}  // namespace caltwin
