#pragma once

#include "sim/base/units.h"
#include "sim/effects/carriages.h"

namespace caltwin {

/// The beam is twisted: the head nods about it as it moves along X. (EAX of ISO 230-1.)
///
///   theta = twist U_x / 2 about +x,  dz = +theta off_y,
///   dy = -theta (z - z_mid + off_z)   [mm]
///
/// Exact in theta. Positive: right-handed about +x, towards +x. A probe that stands off
/// the spindle in y reads heights that the tool does not have.
struct AxisTwist {
  static constexpr std::array<std::string_view, 1> kAxes = {""};
  static constexpr std::array<std::string_view, 2> kAliases = {"EAX", "x"};
  static constexpr std::array kParameters = {
      Parameter{.name = "twist_mrad",
                .unit = "mrad",
                .min = -50,
                .max = 50,
                .prior = Normal{.mean = 0, .sd = 0.4},
                .doc = "Change of the rotation about +x over the whole travel of X; "
                       "right-handed, 0 in the middle."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
  }
  static Shown ShownIn(std::string_view) {
    return {.channel = "z", .covariates = {"x"}};
  }
  static constexpr Effect kDeclaration = {
      .name = "axis_twist",
      .about = "The gantry's beam is twisted, so the head nods as it moves along X.",
      .bucket = Bucket::kMotion,
      .stage = Stage::kFrame,
      .axes = kAxes,
      .parameters = kParameters,
      .formula =
          "dz = theta off_y, dy = -theta (z - z_mid + off_z), "
          "theta = twist U_x / 2",
      .source =
          "ISO 230-1 EAX. Printers carry the probe 20 to 45 mm beside the nozzle, and "
          "Klipper has axis_twist_compensation for it; rails on milled faces 0.1 mrad "
          "over the travel, on extrusions 1 mrad.",
      .twin =
          "bed_tilt: one probe offset shows a tilt about y only; two offsets show "
          "that it grows with the offset, as no bed does.",
      .words = {.plot = "Height against x, once per probe offset: lines that fan out.",
                .values = "Their angle: 0.1 to 1 mrad over the travel; 40 mm of offset "
                          "make 4 to 40 um of it.",
                .cause = "Two rails on one beam not in one plane, an extrusion "
                         "twisted by its ends.",
                .effect = "The probe's map is tilted against the tool's own plane: "
                          "first layers and shallow pockets fail on one side.",
                .action = "Shim one end of the beam; Klipper: "
                          "axis_twist_compensation; or probe with the tool itself."},
      .neutral = Neutral,
      .aliases = kAliases,
      .sight = Sight{.shown = ShownIn}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    AddRotation(asked, Axis::kX, Axis::kX, RadFromMrad(asked.p[0]), errors);
  }
};

}  // namespace caltwin
