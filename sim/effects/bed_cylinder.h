#pragma once

#include "sim/effects/bed_shape.h"

namespace caltwin {

/// The table is bent about one axis: a trough (+) or a barrel (-).
///
///   axis x: dz = height u^2,  axis y: dz = height v^2,  u, v = -1 .. 1 on the plate
///
/// The axis is that along which it curves; `height_um`: how much higher the two edges
/// stand than the middle line.
struct BedCylinder {
  static constexpr std::array<std::string_view, 2> kAxes = {"x", "y"};
  static constexpr std::array kParameters = {
      Parameter{.name = "height_um",
                .unit = "um",
                .min = -10000,
                .max = 10000,
                .prior = Normal{.mean = 0, .sd = 100},
                .doc = "How much higher the two edges stand than the line through the "
                       "middle; -: a barrel."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
  }
  static Shown ShownIn(std::string_view axis) {
    return {.channel = "bed", .covariates = {std::string(axis)}};
  }
  static constexpr Effect kDeclaration = {
      .name = "bed_cylinder",
      .about = "The table (or the plate on it) is bent about one axis, like a trough.",
      .bucket = Bucket::kArtefact,
      .stage = Stage::kArtefact,
      .axes = kAxes,
      .parameters = kParameters,
      .formula = "axis x: dz = height u^2, u = -1 .. 1 over the plate along x",
      .source =
          "Plates held along two edges, extruded tables: 20 to 300 um over 300 "
          "mm.",
      .twin =
          "gantry_sag (x) or straightness EZY (y): the same heights; a plate "
          "turned by 90 degrees takes its shape with it.",
      .words = {.plot = "Heights against one axis: a parabola that turns with the "
                        "plate.",
                .values = "Edges against middle: 20 to 300 um.",
                .cause = "Plate supported along two edges only, clamps, or rolled "
                         "stock with the curl left in.",
                .effect = "Depth varies along that axis; motion is not at fault.",
                .action = "Shim under the middle, surface the table, or use a height "
                          "map."},
      .neutral = Neutral,
      .sight = Sight{.shown = ShownIn}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    const T along = OnPlate(asked)[Index(AxisNamed(asked.axis).value())];
    // The edges of a round bed are on its rim.
    const double at_edge = asked.at.rim_mm > 0 ? 0.5 : 1.0;
    AddHeight(asked, T(MmFromUm(asked.p[0]) * at_edge * along * along), errors);
  }
};

}  // namespace caltwin
