#pragma once

#include "sim/effects/drive.h"
#include "sim/effects/effect.h"

namespace caltwin {

/// The true number of motor steps per millimetre differs from the drawing's.
///
///   actual - commanded = (q - q_home) (s_cfg / s_true - 1)   [mm]
///
/// q commanded position, q_home the home end of that axis, where the error is zero by
/// definition; s_cfg the steps/mm the command was given with. Positive: moves too far.
/// ErrorsAt applies it, since a setting can be wrong on a machine built as drawn.
struct StepsPerMm {
  static constexpr std::array<std::string_view, 3> kAxes = {"x", "y", "z"};
  static constexpr std::array<std::string_view, 1> kTripleZAxes = {"z"};
  static constexpr std::array kParameters = {
      Parameter{.name = "true_steps_per_mm",
                .unit = "1/mm",
                .min = 1e-3,
                .max = 1e7,
                .prior = LogNormal{.median = 800, .factor = 1.01},
                .doc = "Microsteps that truly make one millimetre; replaces the "
                       "drawing's value."}};
  static void Neutral(const Machine& machine,
                      std::string_view axis,
                      std::span<double> values) {
    values[0] = machine.axes[DriveNamed(axis)->slot()].steps_per_mm();
  }
  static constexpr Effect kDeclaration = {
      .name = "steps_per_mm",
      .about =
          "The axis moves a different distance than commanded, in proportion to it.",
      .bucket = Bucket::kMotion,
      .stage = Stage::kDrive,
      .axes = kAxes,
      .parameters = kParameters,
      .formula = "actual - commanded = (q - q_home) (s_cfg / s_true - 1)",
      .source =
          "Definition; size: T8 lead screws of printers and routers are sold with "
          "lead errors of 0.1 to 1 %, entry mistakes reach 1 to 5 %.",
      .twin = "block_size: a wrong artefact looks the same; a second artefact tells.",
      .words =
          {.plot = "A straight line through the error against position.",
           .values = "The slope, in per mille or um per 100 mm; 0.1 to 10 um per mm.",
           .cause = "Wrong steps/mm setting, or a screw whose lead is not as marked.",
           .effect = "Parts are too large or too small in proportion to their size.",
           .action = "Set M92 to s_cfg * commanded / actual."},
      .neutral = Neutral};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    errors->steps_per_mm[DriveNamed(asked.axis)->index] = asked.p[0];
  }
};

}  // namespace caltwin
