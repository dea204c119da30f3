#pragma once

#include <cmath>

#include "sim/base/units.h"
#include "sim/effects/effect.h"

namespace caltwin {

/// The stylus' ball stands beside the spindle's axis, and turns with the spindle.
///
///   dx = offset cos(phase + spindle),  dy = offset sin(phase + spindle)   [mm]
///
/// of touches only: a gauge reads the moving part, not the tip.
struct TipRunout {
  static constexpr std::array<std::string_view, 1> kAxes = {""};
  static constexpr std::array kParameters = {
      Parameter{.name = "offset_um",
                .unit = "um",
                .min = 0,
                .max = 5000,
                .prior = LogNormal{.median = 15, .factor = 2.5},
                .doc = "Distance of the ball's centre from the spindle's axis."},
      Parameter{.name = "phase_deg",
                .unit = "deg",
                .min = -360,
                .max = 360,
                .prior = Uniform{.min = -180, .max = 180},
                .doc = "Direction from the axis to the ball at spindle 0, from +x, "
                       "counter-clockwise from above.",
                .role = Role::kPhase}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = values[1] = 0;
  }
  static Shown ShownIn(std::string_view) {
    return {.channel = "probe", .covariates = {"theta"}};
  }
  static constexpr Effect kDeclaration = {
      .name = "tip_runout",
      .about = "The ball of the stylus stands beside the spindle's axis.",
      .bucket = Bucket::kMeasurement,
      .stage = Stage::kProbe,
      .axes = kAxes,
      .parameters = kParameters,
      .formula = "tip = axis + offset (cos, sin)(phase + spindle angle)",
      .source =
          "Collet and stylus as clamped: 5 to 50 um; centred by its screws: "
          "below 5 um (ISO 230-10).",
      .twin =
          "The artefact's place, which takes it whole at one orientation; four "
          "orientations of the spindle (or two, 180 degrees apart) separate them.",
      .words = {.plot = "Centre of a ring against spindle angle: a circle.",
                .values = "Its radius: 5 to 50 um.",
                .cause = "The probe clamped off centre, a bent stylus, a worn collet.",
                .effect = "Positions are off by as much; sizes are not.",
                .action = "Centre the ball with the probe's screws against a dial, or "
                          "probe always at the same spindle angle and set the "
                          "offset."},
      .neutral = Neutral,
      .sight = Sight{.shown = ShownIn}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    using std::cos;
    using std::sin;
    if (asked.at.kind != RowKind::kTouch) return;
    const T offset_mm = MmFromUm(asked.p[0]);
    const T direction_rad = RadFromDeg(T(asked.p[1] + asked.at.probe_angle_deg));
    errors->motion_mm[0] += offset_mm * cos(direction_rad);
    errors->motion_mm[1] += offset_mm * sin(direction_rad);
  }
};

}  // namespace caltwin
