#pragma once

#include "sim/base/units.h"
#include "sim/effects/carriages.h"

namespace caltwin {

/// The beam hangs through: the tool is lowest in the middle of X. (EZX of ISO 230-1.)
///
///   dz = sag (U_x^2 - 1/3),  U_x = -1 .. 1 over the travel   [mm]
///
/// Positive: the middle hangs lower than the ends; peak to valley.
struct GantrySag {
  static constexpr std::array<std::string_view, 1> kAxes = {""};
  static constexpr std::array<std::string_view, 2> kAliases = {"EZX", "x"};
  static constexpr std::array kParameters = {
      Parameter{.name = "sag_um",
                .unit = "um",
                .min = -5000,
                .max = 5000,
                .prior = Normal{.mean = 0, .sd = 40},
                .doc = "Ends against middle over the whole travel; +: the middle of "
                       "the beam hangs lower."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
  }
  static Shown ShownIn(std::string_view) {
    return {.channel = "z", .covariates = {"x"}};
  }
  static constexpr Effect kDeclaration = {
      .name = "gantry_sag",
      .about = "The gantry's beam hangs through: the tool is lowest in mid X.",
      .bucket = Bucket::kMotion,
      .stage = Stage::kFrame,
      .axes = kAxes,
      .parameters = kParameters,
      .formula = "dz = sag (U_x^2 - 1/3), U_x = -1 .. 1 over the travel",
      .source =
          "A beam on two ends bends by F L^3 / (48 E I) under the head, nearly as x^2 "
          "about its middle: 5 kg on 600 mm of 40x80 extrusion on edge (I = 54 cm^4) "
          "6 um, of 20x20 (0.7 cm^4) 0.45 mm; bent rails add 5 to 100 um.",
      .twin =
          "bed_cylinder along x: the same heights; a plate turned by 90 degrees "
          "takes the bed's shape with it and leaves the beam's.",
      .words = {.plot = "Height of any flat against x: a parabola that stays with the "
                        "machine when the plate is turned.",
                .values = "Its height, ends to middle: 5 to 100 um.",
                .cause = "A thin or long beam, a heavy spindle, rails bolted to a "
                         "bent extrusion.",
                .effect = "Pockets are deeper in the middle of X; a surfaced table "
                          "takes on the shape and hides it.",
                .action = "Stiffen or pre-bend the beam; a height map (mesh) corrects "
                          "it only if probed on a flat you trust."},
      .neutral = Neutral,
      .aliases = kAliases,
      .sight = Sight{.shown = ShownIn}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    errors->motion_mm[Index(Axis::kZ)] +=
        MmFromUm(asked.p[0]) *
        Bow(asked.machine, Axis::kX, asked.q_mm[Index(Axis::kX)]);
  }
};

}  // namespace caltwin
