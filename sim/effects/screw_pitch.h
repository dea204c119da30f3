#pragma once

#include "sim/base/units.h"
#include "sim/effects/drive.h"
#include "sim/effects/effect.h"

namespace caltwin {

/// One of the screws under a bed lifts by more (+) or less than commanded.
///
///   screw - commanded = error q,  q its height over the lower endstop   [mm]
struct ScrewPitch {
  static constexpr std::array kParameters = {
      Parameter{.name = "error_ppm",
                .unit = "ppm",
                .min = -50000,
                .max = 50000,
                .prior = Normal{.mean = 0, .sd = 300},
                .doc = "+: the screw lifts the bed farther than commanded."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
  }
  static Shown In(std::string_view axis) {
    return {.channel = std::string(axis), .covariates = {DriveCovariate(axis)}};
  }
  static constexpr Effect kDeclaration = {
      .name = "screw_pitch",
      .about = "One of the screws under the bed lifts too far, or not far enough.",
      .bucket = Bucket::kMotion,
      .stage = Stage::kDrive,
      .parameters = kParameters,
      .formula = "screw - commanded = error q, q its height over the lower endstop",
      .source =
          "Rolled trapezoidal screws: 0.1 to 0.3 mm over 300 mm (300 to 1000 ppm), "
          "ground ones a tenth of that; unlike brands on one machine.",
      .twin =
          "angular EAZ, EBZ: a gantry that leans as the bed moves tilts heights alike; "
          "a gauge on a fixed post does not feel it. All three alike are scale.z.",
      .words =
          {.plot = "Height near that screw against its travel: a line.",
           .values = "100 to 1000 ppm; 300 ppm are 0.06 mm over 200 mm.",
           .cause = "Screws of unlike make, lead or lubrication; a worn nut.",
           .effect =
               "A bed levelled at one height is tilted at another: tall parts lean.",
           .action =
               "Fit three screws of one batch; else set steps per mm of that motor "
               "where the firmware has one for each."},
      .neutral = Neutral,
      .sight = Sight{.shown = In}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    DriveError_mm(asked.axis, errors) +=
        FractionFromPpm(asked.p[0]) * DriveAt_mm(asked);
  }
};

}  // namespace caltwin
