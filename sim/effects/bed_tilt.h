#pragma once

#include "sim/base/units.h"
#include "sim/effects/effect.h"

namespace caltwin {

/// The table, and all that stands on it, is tilted about the middle of the travel at
/// z = 0.
///
///   dz = s_x (x - x_mid) + s_y (y - y_mid),  dx = -s_x z,  dy = -s_y z   [mm]
///
/// First order in the slopes: neglects R s^2 / 2 of the ball (0.01 um at 5 mrad, R = 1
/// mm).
struct BedTilt {
  static constexpr std::array<std::string_view, 1> kAxes = {""};
  static constexpr std::array kParameters = {
      Parameter{.name = "slope_x_mrad",
                .unit = "mrad",
                .min = -50,
                .max = 50,
                .prior = Normal{.mean = 0, .sd = 2},
                .doc = "Height gained per length along +x."},
      Parameter{.name = "slope_y_mrad",
                .unit = "mrad",
                .min = -50,
                .max = 50,
                .prior = Normal{.mean = 0, .sd = 2},
                .doc = "Height gained per length along +y."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = values[1] = 0;
  }
  static constexpr Effect kDeclaration = {
      .name = "bed_tilt",
      .about = "The table is not parallel to the plane of X and Y.",
      .bucket = Bucket::kArtefact,
      .stage = Stage::kArtefact,
      .axes = kAxes,
      .parameters = kParameters,
      .formula =
          "dz = s_x (x - x_mid) + s_y (y - y_mid); the middle of a round bed is its "
          "origin",
      .source = "Unsurfaced spoil boards: 0.5 to 5 mrad.",
      .twin =
          "squareness A0Z, B0Z: heights alone cannot tell; a side face at two heights "
          "does.",
      .words = {.plot = "Height of the table against x and y: a plane.",
                .values = "Slopes of 0.5 to 5 mm per metre.",
                .cause = "Table shimmed or clamped unevenly.",
                .effect = "Pockets vary in depth across the part.",
                .action = "Shim or surface the table."},
      .neutral = Neutral};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    if (!asked.at.on_table) return;
    const T slope_x = RadFromMrad(asked.p[0]);
    const T slope_y = RadFromMrad(asked.p[1]);
    const Vec3<double> middle_mm =
        asked.at.rim_mm > 0 ? Vec3<double>(0, 0, 0)
                            : Vec3<double>(asked.machine.axis(Axis::kX).mid_mm(),
                                           asked.machine.axis(Axis::kY).mid_mm(),
                                           0);
    const Vec3<T> r_mm =
        asked.q_mm + (asked.at.probe_off_mm - middle_mm).template cast<T>();
    const Vec3<double>& n = asked.at.n;
    errors->artefact_mm += n[2] * (slope_x * r_mm[0] + slope_y * r_mm[1]) -
                           (n[0] * slope_x + n[1] * slope_y) * r_mm[2];
  }
};

}  // namespace caltwin
