#pragma once

#include "sim/effects/drive.h"
#include "sim/effects/effect.h"

namespace caltwin {

/// A nut with play on one of the screws under a bed: after its motor turns back it
/// stays behind by the gap.
///
///   screw - commanded = -dir gap / 2,  dir +1: last moved up
struct ScrewBacklash {
  static constexpr std::array kParameters = {
      Parameter{.name = "gap_mm",
                .unit = "mm",
                .min = 0,
                .max = 2,
                .prior = LogNormal{.median = 0.03, .factor = 2},
                .doc = "Full width of the gap."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
  }
  static Shown In(std::string_view axis) {
    return {.channel = std::string(axis), .covariates = {SenseCovariate(axis)}};
  }
  static constexpr Effect kDeclaration = {
      .name = "screw_backlash",
      .about =
          "The nut of one screw under the bed has play: it lags when it turns back.",
      .bucket = Bucket::kMotion,
      .stage = Stage::kDrive,
      .parameters = kParameters,
      .formula = "screw: -dir gap / 2 of height, dir the sense of its motor",
      .source =
          "Brass nuts on T8 screws: 0.02 to 0.1 mm where rails hold the bed's weight "
          "back; with the weight on the nut the gap stays shut.",
      .twin =
          "backlash.z, all three alike (baseline); readings near each screw, moved "
          "up and down, tell which.",
      .words = {.plot =
                    "Height near that screw after moves up less after moves down: a "
                    "constant.",
                .values = "0.02 to 0.1 mm.",
                .cause = "A worn nut; a bed so light, or so stiffly guided, that its "
                         "weight does not shut the gap.",
                .effect =
                    "Z-hops tilt the bed a little; levelling depends on the sense.",
                .action = "Fit an anti-backlash nut or a heavier bed; always approach "
                          "from below."},
      .neutral = Neutral,
      .sight = Sight{.shown = In}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    errors->screw_lost_motion_mm[DriveNamed(asked.axis)->index] += asked.p[0];
  }
};

}  // namespace caltwin
