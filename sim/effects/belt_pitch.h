#pragma once

#include "sim/base/units.h"
#include "sim/effects/drive.h"
#include "sim/effects/knob_turns.h"
#include "sim/machine/kinds/delta/knobs.h"

namespace caltwin {

/// A delta's tower whose belt moves its carriage by more (+) or less than commanded,
/// counted from its endstop; a CoreXY's belt that does, counted from where it is homed.
struct BeltPitch {
  static constexpr std::array kParameters = {
      Parameter{.name = "error_ppm",
                .unit = "ppm",
                .min = -50000,
                .max = 50000,
                .prior = Normal{.mean = 0, .sd = 300},
                .doc = "+: the carriage moves farther than commanded."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
  }
  static Shown In(std::string_view axis) {
    return {.channel = std::string(axis), .covariates = {"motor_" + std::string(axis)}};
  }
  static constexpr Effect kDeclaration = {
      .name = "belt_pitch",
      .about =
          "One tower's belt or pulley moves its carriage too far, or not far enough.",
      .bucket = Bucket::kMotion,
      .stage = Stage::kFrame,
      .parameters = kParameters,
      .formula = "carriage travel = motor travel (1 + error), from the endstop",
      .source =
          "Belts stretched by their tension: 200 to 1000 ppm; pulleys of other make "
          "alike.",
      .twin =
          "tower_lean, where only heights are measured: both grow along the tower. "
          "Measure along x and y too. All three belts alike are the baseline's scale.",
      .words =
          {.plot =
               "Error in z against that carriage's travel: a line through its endstop.",
           .values = "100 to 1000 ppm; 300 ppm are 0.06 mm over 200 mm.",
           .cause = "Unequal tension, a belt or pulley of another make.",
           .effect = "Parts of wrong size towards that tower, heights off the more the "
                     "lower the carriage.",
           .action = "Tension the belts alike (by their tone), or set steps per mm of "
                     "that motor."},
      .neutral = Neutral,
      .sight = Sight{.shown = In}};

  template <typename T>
  static std::array<KnobTurn<T>, 1> Turns(std::string_view axis, std::span<const T> p) {
    return {{{kBeltKnob + TowerIndex(axis), FractionFromPpm(p[0])}}};
  }
  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    const auto& drives = asked.at.drives;
    if (!drives) return AddTurns(asked, Turns(asked.axis, asked.p), errors);
    const int i = DriveNamed(asked.axis)->index;
    const T farther_mm =
        FractionFromPpm(asked.p[0]) * (DriveAt_mm(asked) - drives->home_mm[i]);
    errors->motion_mm +=
        drives->map->axes_by_drive.col(i).template cast<T>() * farther_mm;
  }
};

}  // namespace caltwin
