#pragma once

#include "sim/effects/drive.h"

namespace caltwin {

/// A delta's carriage with play: after its motor turns back it stays behind by the gap.
///
///   carriage - commanded = -dir gap / 2,  dir +1: last moved down
struct CarriageBacklash {
  static constexpr std::array kParameters = {
      Parameter{.name = "gap_mm",
                .unit = "mm",
                .min = 0,
                .max = 1,
                .prior = LogNormal{.median = 0.03, .factor = 2},
                .doc = "Full width of the gap."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
  }
  static Shown In(std::string_view axis) {
    return {.channel = std::string(axis), .covariates = {"dir_" + std::string(axis)}};
  }
  static constexpr Effect kDeclaration = {
      .name = "carriage_backlash",
      .about =
          "A carriage has play against its belt or rail: it lags behind when it turns "
          "back.",
      .bucket = Bucket::kMotion,
      .stage = Stage::kDrive,
      .parameters = kParameters,
      .formula = "carriage: -dir gap / 2 of travel, dir the sense of its motor",
      .source = "Wheels or bushes with play, belt teeth: 0.02 to 0.1 mm.",
      .twin =
          "trigger_scatter, where the sense of approach is not known; touches after "
          "moves up and down tell.",
      .words = {.plot = "Height after moves up less height after moves down: a "
                        "constant, seen most near that tower.",
                .values = "0.02 to 0.1 mm.",
                .cause = "Loose carriage wheels, worn bushes, a belt clip that gives.",
                .effect =
                    "Seams and corners, sizes that depend on the sense of travel.",
                .action = "Adjust the eccentric nuts, preload the carriage, shorten "
                          "the belt clip."},
      .neutral = Neutral,
      .sight = Sight{.shown = In},
      .delta_axes = kTowerAxes};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    errors->motor_lost_motion_mm[DriveNamed(asked.axis)->index] += asked.p[0];
  }
};

}  // namespace caltwin
