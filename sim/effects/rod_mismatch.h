#pragma once

#include "sim/base/units.h"
#include "sim/effects/knob_turns.h"

namespace caltwin {

/// Rods of a delta that differ from their tower's arm length, seen from above `a1` the
/// clockwise one of tower a, `a2` the other, `a` both alike.
struct RodMismatch {
  static constexpr std::array<std::string_view, 9> kAxes = {
      "a", "b", "c", "a1", "a2", "b1", "b2", "c1", "c2"};
  static constexpr std::array kParameters = {
      Parameter{.name = "length_error_mm",
                .unit = "mm",
                .min = -10,
                .max = 10,
                .prior = Normal{.mean = 0, .sd = 0.1},
                .doc = "Longer than its tower's `arm_length_mm`: +."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
  }
  static Shown In(std::string_view) {
    return {.channel = "z", .covariates = {"x", "y"}};
  }
  static constexpr Effect kDeclaration = {
      .name = "rod_mismatch",
      .about = "A tower's rods, or one of them, are longer than drawn.",
      .bucket = Bucket::kMotion,
      .stage = Stage::kFrame,
      .parameters = kParameters,
      .formula =
          "length of the rod = arm length + error; .a both rods of tower a alike",
      .source = "Rods glued from tube and joints: 0.05 to 0.3 mm; cut in one jig 0.02.",
      .twin =
          "One rod against the other of the same tower looks like tower_twist in z "
          "alone; both alike look like endstop and radius. Measure in the plane and in "
          "z.",
      .words = {.plot = "Error in z against position: saddle-shaped, leaning towards "
                        "that tower; in the plane the nozzle turns aside.",
                .values =
                    "0.05 to 0.3 mm; a rod 0.1 mm longer moves the nozzle by up to 0.1 "
                    "mm and tilts the effector by 2.5 mrad at 40 mm between rods.",
                .cause = "Rods not cut in one jig, worn or replaced ball joints.",
                .effect = "The effector tilts with its place: heights that no firmware "
                          "of three rods can correct, parts askew.",
                .action = "Measure the rods against each other on two pins and make "
                          "them alike; put the pairs that match best on one tower."},
      .neutral = Neutral,
      .sight = Sight{.shown = In}};

  template <typename T>
  static std::array<KnobTurn<T>, 2> Turns(std::string_view axis, std::span<const T> p) {
    const int first = kRodKnob + 2 * TowerIndex(axis.substr(0, 1));
    if (axis.size() < 2) return {{{first, p[0]}, {first + 1, p[0]}}};
    return {{{axis[1] == '1' ? first : first + 1, p[0]}, {}}};
  }
  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    AddTurns(asked, Turns(asked.axis, asked.p), errors);
  }
};

}  // namespace caltwin
