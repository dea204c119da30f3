#pragma once

#include <array>
#include <string_view>

#include "sim/effects/drive.h"
#include "sim/effects/effect.h"

namespace caltwin {

/// Motors under the bed are plugged into each other's drivers: two of them, so that
/// what one is told the other does, or all three in a ring. The axis names the screws
/// in the order in which a driver turns the next one, the last the first: `z1z2z3`,
/// what z1 is told screw 2 does, what z2 is told screw 3, what z3 is told screw 1.
///
///   screw i += z_j - z_i   [mm],  j the screw before it in the name
///
/// Nothing shows while all are told the same.
struct MotorsSwapped {
  /// All wirings of three motors but the right one: pairs, then rings.
  static constexpr std::array<std::string_view, 5> kWirings = {
      "z1z2", "z1z3", "z2z3", "z1z2z3", "z1z3z2"};
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
  /// The screw that each driver turns, both counted from 0.
  static constexpr std::array<int, 3> ScrewsTurned(std::string_view wiring) {
    std::array<int, 3> turned{0, 1, 2};
    const std::size_t size = wiring.size();
    for (std::size_t at = 0; at < size; at += 2) {
      const auto driver = static_cast<std::size_t>(wiring[at + 1] - '1');
      turned[driver] = wiring[(at + 3) % size] - '1';
    }
    return turned;
  }
  static Shown In(std::string_view wiring) {
    Shown shown{.channel = "z"};
    for (std::size_t at = 0; at < wiring.size(); at += 2) {
      shown.covariates.push_back(DriveCovariate(wiring.substr(at, 2)));
    }
    return shown;
  }
  static constexpr Effect kDeclaration = {
      .name = "motors_swapped",
      .about =
          "Motors under the bed are plugged into each other's drivers: two of them, "
          "or all three in a ring.",
      .bucket = Bucket::kMotion,
      .stage = Stage::kDrive,
      .parameters = kParameters,
      .formula =
          "screw i += z_j - z_i, j the screw before it in the name (of the first the "
          "last): it does what that one is told",
      .source = "Drivers numbered in another order than M671 or z_positions list them.",
      .twin =
          "pivot_position: pivots entered in each other's places are the same; their "
          "size tells.",
      .words =
          {.plot = "Raise one screw: the bed rises at another.",
           .values = "Whole: it is so or it is not.",
           .cause = "Cables or driver numbers exchanged.",
           .effect = "Levelling makes the tilt worse each round, or circles.",
           .action =
               "Exchange the cables, or the driver numbers (M584), or the positions "
               "in M671."},
      .neutral = Neutral,
      .sight = Sight{.shown = In}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    const auto told_mm = ScrewsOf_mm(asked.at);
    if (!told_mm) return;
    const std::array<int, 3> turned = ScrewsTurned(asked.axis);
    for (int driver = 0; driver < 3; ++driver) {
      const int screw = turned[static_cast<std::size_t>(driver)];
      errors->screw_mm[screw] += asked.p[0] * ((*told_mm)[driver] - (*told_mm)[screw]);
    }
  }
};

}  // namespace caltwin
