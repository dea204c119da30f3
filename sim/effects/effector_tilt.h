#pragma once

#include "sim/base/units.h"
#include "sim/effects/effect.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {

/// A delta's tool stands crooked on its effector: a constant shift of its tip, by the
/// distance h between tip and effector joints.
///
///   d = h (-tilt_y, +tilt_x, 0)   [mm], right-handed tilts
///
/// Every setup's place takes it up: no plan sees it, and it is never a finding. Tilt
/// that depends on the pose comes from the rods.
struct EffectorTilt {
  static constexpr std::array<std::string_view, 1> kAxes = {""};
  static constexpr std::array kParameters = {
      Parameter{.name = "tilt_x_mrad",
                .unit = "mrad",
                .min = -200,
                .max = 200,
                .prior = Normal{.mean = 0, .sd = 10},
                .doc = "Of the tool about x, right-handed."},
      Parameter{.name = "tilt_y_mrad",
                .unit = "mrad",
                .min = -200,
                .max = 200,
                .prior = Normal{.mean = 0, .sd = 10},
                .doc = "Of the tool about y, right-handed."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = values[1] = 0;
  }
  static Shown In(std::string_view) { return {.channel = "x", .covariates = {}}; }
  static constexpr Effect kDeclaration = {
      .name = "effector_tilt",
      .about = "The tool stands crooked on its effector, the same everywhere.",
      .bucket = Bucket::kMotion,
      .stage = Stage::kProbe,
      .parameters = kParameters,
      .formula = "d = h (-tilt_y, tilt_x, 0), h from the tip to the effector's joints",
      .source = "Nozzles and cutters held askew: 5 to 30 mrad.",
      .twin =
          "Where the work lies: a constant shift is one of the origin, and no plan "
          "tells them apart.",
      .words = {.plot = "Nothing: every reading is moved alike.",
                .values = "5 to 30 mrad.",
                .cause = "A hot end or spindle clamped askew.",
                .effect = "A shift of the origin; a cutter's own end marks the floor.",
                .action =
                    "Square the tool against the bed by a try square: no campaign "
                    "sees it."},
      .neutral = Neutral,
      .sight = Sight{.shown = In}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    const double h_mm = asked.machine.kind->TipBelowJoints_mm(asked.machine);
    errors->motion_mm[0] -= h_mm * RadFromMrad(asked.p[1]);
    errors->motion_mm[1] += h_mm * RadFromMrad(asked.p[0]);
  }
};

}  // namespace caltwin
