#pragma once

#include "sim/base/units.h"
#include "sim/effects/drive.h"
#include "sim/effects/effect.h"

namespace caltwin {

/// The screw's lead changes steadily along it, so the error bends.
///
///   actual - commanded = bow (U^2 - 1/3),  U = (q - mid) / (travel / 2)   [mm]
///
/// U runs from -1 to 1 over the travel, q is the commanded position: of a tower or a
/// screw under a bed that of its motor, in whose sense + is. Positive: both ends go to
/// + against the middle; bow is peak to valley over the travel. The third takes off the
/// mean, which any placement absorbs.
struct PitchProgressive {
  static constexpr std::array<std::string_view, 3> kAxes = {"x", "y", "z"};
  static constexpr std::array kParameters = {
      Parameter{.name = "bow_um",
                .unit = "um",
                .min = -5000,
                .max = 5000,
                .prior = Normal{.mean = 0, .sd = 20},
                .doc = "Peak to valley over the travel; +: both ends go to +."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
  }
  static Shown In(std::string_view axis) {
    return {.channel = std::string(axis), .covariates = {DriveCovariate(axis)}};
  }
  static constexpr Effect kDeclaration = {
      .name = "pitch_progressive",
      .about = "The lead changes along the screw, so steps/mm fits at one place only.",
      .bucket = Bucket::kMotion,
      .stage = Stage::kDrive,
      .axes = kAxes,
      .parameters = kParameters,
      .formula = "actual - commanded = bow (U^2 - 1/3), U = -1 .. 1 over the travel",
      .source =
          "ISO 3408-3, variation of the actual travel over 300 mm: 23 um for ball "
          "screws of grade 5, 52 um of grade 7, 210 um of grade 10 (rolled).",
      .twin =
          "straightness: a ball-bar alone sees one bend for both; a laser along the "
          "axis tells. pitch_map: a bend of any other shape.",
      .words =
          {.plot = "Error against position, best straight line taken off: a parabola.",
           .values = "5 to 50 um between the middle and the ends.",
           .cause = "Screw rolled or ground with a drifting lead, screw worn in the "
                    "middle, a belt stretched unevenly.",
           .effect =
               "A scale calibrated in the middle is wrong at the ends: by 4 bow per "
               "travel in slope.",
           .action = "Replace the screw, or enter a screw table (LinuxCNC compensation "
                     "file) of five or more points."},
      .neutral = Neutral,
      .sight = Sight{.shown = In}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    const AxisDrawing& drawing = TravelOf(asked.machine, asked.axis);
    const T u = (DriveAt_mm(asked) - drawing.mid_mm()) / (drawing.travel_mm() / 2);
    DriveError_mm(asked.axis, errors) += MmFromUm(asked.p[0]) * (u * u - 1.0 / 3);
  }
};

}  // namespace caltwin
