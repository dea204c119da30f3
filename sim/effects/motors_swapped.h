#pragma once

#include "sim/effects/drive.h"
#include "sim/effects/effect.h"

namespace caltwin {

/// Two of the motors under the bed are plugged into each other's drivers: what one is
/// told, the other does.
///
///   screw i += z_j - z_i,  screw j -= z_j - z_i   [mm]
///
/// Nothing shows while both are told the same.
struct MotorsSwapped {
  static constexpr std::array<std::string_view, 3> kPairs = {"z1z2", "z1z3", "z2z3"};
  static constexpr std::array kParameters = {
      Parameter{.name = "swapped_part",
                .unit = "1",
                .min = 0,
                .max = 1.5,
                .prior = Normal{.mean = 1, .sd = 0.2},
                .doc = "1: exchanged, as it is where a file says nothing; 0: not.",
                .if_named = 1}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
  }
  /// The two screws of a pair such as "z1z2".
  static constexpr std::array<int, 2> ScrewsOf(std::string_view pair) {
    return {pair[1] - '1', pair[3] - '1'};
  }
  static Shown In(std::string_view pair) {
    return {.channel = "z",
            .covariates = {DriveCovariate(pair.substr(0, 2)),
                           DriveCovariate(pair.substr(2))}};
  }
  static constexpr Effect kDeclaration = {
      .name = "motors_swapped",
      .about = "Two of the motors under the bed are plugged into each other's drivers.",
      .bucket = Bucket::kMotion,
      .stage = Stage::kDrive,
      .parameters = kParameters,
      .formula =
          "screw i += z_j - z_i, screw j the opposite: each does what the other is "
          "told",
      .source = "Drivers numbered in another order than M671 or z_positions list them.",
      .twin =
          "pivot_position: two pivots entered in each other's place are the same; "
          "their size tells.",
      .words = {.plot = "Raise one screw: the bed rises at another.",
                .values = "Whole: it is so or it is not.",
                .cause = "Cables or driver numbers exchanged.",
                .effect = "Levelling makes the tilt worse each round, or circles.",
                .action =
                    "Exchange the two cables, or the driver numbers (M584), or the "
                    "two positions in M671."},
      .neutral = Neutral,
      .sight = Sight{.shown = In},
      .triple_z_axes = kPairs};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    const auto told_mm = MotorsOf_mm(asked.at);
    if (!told_mm) return;
    const auto [i, j] = ScrewsOf(asked.axis);
    const T more_mm = asked.p[0] * ((*told_mm)[j] - (*told_mm)[i]);
    errors->motor_mm[i] += more_mm;
    errors->motor_mm[j] -= more_mm;
  }
};

}  // namespace caltwin
