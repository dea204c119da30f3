#pragma once

#include "sim/effects/bed_shape.h"

namespace caltwin {

/// The table is a bowl (+) or a dome (-).
///
///   dz = height (u^2 + v^2) / 2,  u, v = -1 .. 1 on the plate   [mm]
///
/// `height_um`: how much higher the four corners stand than the middle.
struct BedBowl {
  static constexpr std::array<std::string_view, 1> kAxes = {""};
  static constexpr std::array kParameters = {
      Parameter{.name = "height_um",
                .unit = "um",
                .min = -10000,
                .max = 10000,
                .prior = Normal{.mean = 0, .sd = 100},
                .doc = "How much higher the corners of the travel stand than its "
                       "middle; -: a dome."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
  }
  static Shown ShownIn(std::string_view) {
    return {.channel = "bed", .covariates = {"x", "y"}};
  }
  static constexpr Effect kDeclaration = {
      .name = "bed_bowl",
      .about = "The table (or the plate on it) is dished like a bowl, or domed.",
      .bucket = Bucket::kArtefact,
      .stage = Stage::kArtefact,
      .axes = kAxes,
      .parameters = kParameters,
      .formula = "dz = height (u^2 + v^2) / 2, u, v = -1 .. 1 over the plate",
      .source =
          "Cast or rolled plate, clamped at its rim or heated from below: 20 to "
          "300 um over 300 mm.",
      .twin =
          "gantry_sag with straightness EZY: a beam and a rail that bend alike; "
          "turn the plate by 90 degrees, and compare with a second flat.",
      .words = {.plot = "Map of heights: rings about the middle.",
                .values = "Corners against middle: 20 to 300 um.",
                .cause = "Plate bent by clamps, by heat from below, or as rolled.",
                .effect = "Depth and first layer vary from middle to corner; motion is "
                          "not at fault.",
                .action = "Surface or shim the table; a height map (mesh) corrects "
                          "it."},
      .neutral = Neutral,
      .sight = Sight{.shown = ShownIn}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    const Eigen::Matrix<T, 2, 1> uv = OnPlate(asked);
    AddHeight(asked, T(MmFromUm(asked.p[0]) * uv.squaredNorm() / 2.0), errors);
  }
};

}  // namespace caltwin
