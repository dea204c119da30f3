#pragma once

#include "sim/effects/drive.h"
#include "sim/effects/effect.h"

namespace caltwin {

/// Lost motion between nut and carriage: a gap of width b.
///
///   moving in +: actual - commanded = -b / 2;   moving in -: +b / 2   [mm]
///
/// about the middle of the gap. Where a hanging weight keeps the gap shut
/// (WeightKeepsGapShut) the carriage never crosses it and nothing is lost. Neglects the
/// coasting of the carriage after abrupt stops (m v^2 / 2F: 10 um at 5 mm/s, 8 N, 6
/// kg), which changes no reading taken while the nut pushes.
struct Backlash {
  static constexpr std::array<std::string_view, 3> kAxes = {"x", "y", "z"};
  static constexpr std::array<std::string_view, 1> kTripleZAxes = {"z"};
  static constexpr std::array kParameters = {
      Parameter{.name = "gap_mm",
                .unit = "mm",
                .min = 0,
                .max = 5,
                .prior = LogNormal{.median = 0.05, .factor = 2.5},
                .doc = "Travel lost at a reversal; a width, without sign."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
  }
  static constexpr Effect kDeclaration = {
      .name = "backlash",
      .about =
          "A move that reverses first takes up a gap, so where the carriage stops "
          "depends on the side it came from.",
      .bucket = Bucket::kMotion,
      .stage = Stage::kDrive,
      .axes = kAxes,
      .parameters = kParameters,
      .formula = "actual - commanded = -s b / 2, s the sense of the last move",
      .source =
          "Reversal value B of ISO 230-2; plain T8 nuts 0.05 to 0.2 mm, preloaded "
          "ball screws below 0.01 mm.",
      .twin =
          "probe_pretravel: spans see pre-travel + b/2 only; a release on the way "
          "out, a dial or a laser tells.",
      .words = {.plot = "Two parallel lines, one for each approach direction.",
                .values = "The distance of the lines: 5 um to 0.2 mm.",
                .cause = "Worn or unloaded nut, loose bearing or coupling.",
                .effect = "Circles flatten, pockets and bosses miss by the gap.",
                .action = "Preload or replace the nut; else set M425 to the gap."},
      .neutral = Neutral};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    const Drive drive = DriveNamed(asked.axis).value();
    const bool is_z = asked.axis == "z";
    if (is_z && WeightKeepsGapShut(Axis::kZ, asked.machine.axis(Axis::kZ))) return;
    errors->lost_motion_mm[drive.index] += asked.p[0];
  }
};

}  // namespace caltwin
