#pragma once

#include "sim/effects/bed_shape.h"

namespace caltwin {

/// The table is twisted like a propeller: two opposite corners up, two down.
///
///   dz = height u v,  u, v = -1 .. 1 on the plate   [mm]
///
/// `height_um`: how much higher than the middle the corners (max, max) and (min, min)
/// stand; the others stand as much lower.
struct BedTwist {
  static constexpr std::array<std::string_view, 1> kAxes = {""};
  static constexpr std::array kParameters = {
      Parameter{.name = "height_um",
                .unit = "um",
                .min = -10000,
                .max = 10000,
                .prior = Normal{.mean = 0, .sd = 100},
                .doc = "How much higher than the middle the corners (max, max) and "
                       "(min, min) stand."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
  }
  static Shown ShownIn(std::string_view) {
    return {.channel = "bed", .covariates = {"x", "y"}};
  }
  static constexpr Effect kDeclaration = {
      .name = "bed_twist",
      .about =
          "The table (or the plate on it) is twisted: two opposite corners stand "
          "up, the others down.",
      .bucket = Bucket::kArtefact,
      .stage = Stage::kArtefact,
      .axes = kAxes,
      .parameters = kParameters,
      .formula = "dz = height u v, u, v = -1 .. 1 over the plate",
      .source = "Four supports never lie in one plane: 20 to 300 um over 300 mm.",
      .twin =
          "angular EBY (a gantry that rolls as Y moves): the same heights; turned "
          "by 90 degrees the plate's twist changes its sign, the gantry's does "
          "not.",
      .words = {.plot = "Map of heights: a saddle with its ridges on the diagonals.",
                .values = "A corner against the middle: 20 to 300 um.",
                .cause = "A table screwed to four points that do not lie in a plane, "
                         "rails of Y not parallel in height.",
                .effect = "Depth errs with opposite signs at neighbouring corners.",
                .action = "Shim one corner by four times the height; a tilt correction "
                          "cannot mend it, a height map can."},
      .neutral = Neutral,
      .sight = Sight{.shown = ShownIn}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    const Eigen::Matrix<T, 2, 1> uv = OnPlate(asked);
    AddHeight(asked, T(MmFromUm(asked.p[0]) * uv[0] * uv[1]), errors);
  }
};

}  // namespace caltwin
