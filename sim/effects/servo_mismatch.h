#pragma once

#include "sim/base/units.h"
#include "sim/effects/circling.h"

namespace caltwin {

/// X and Y follow their commands with different delays: a circle becomes an ellipse
/// along a diagonal, the other one for the other sense.
///
///   dx = +m v_x / 2,  dy = -m v_y / 2,  m = tau_y - tau_x
///
/// so radially -m v sense sin(2 theta) / 2; sense + counter-clockwise.
struct ServoMismatch {
  static constexpr std::array<std::string_view, 1> kAxes = {""};
  static constexpr std::array kParameters = {
      Parameter{.name = "mismatch_ms",
                .unit = "ms",
                .min = -1000,
                .max = 1000,
                .prior = Normal{.mean = 0, .sd = 0.5},
                .doc = "Delay of Y minus delay of X; +: Y follows later."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
  }
  static Shown ShownIn(std::string_view) {
    return {.channel = "y", .covariates = {"theta", "feed", "dir_x", "dir_y"}};
  }
  static constexpr Effect kDeclaration = {
      .name = "servo_mismatch",
      .about = "X and Y follow their commands with different delays.",
      .bucket = Bucket::kMotion,
      .stage = Stage::kFrame,
      .axes = kAxes,
      .parameters = kParameters,
      .formula = "dr = -m v sense sin(2 theta) / 2, m = tau_y - tau_x",
      .source =
          "ISO 230-4 and ball-bar makers' analyses: following errors of unequal "
          "loop gains, 0.1 to 1 ms; 1 ms at 30 mm/s makes +-15 um.",
      .twin =
          "squareness: an ellipse along the same diagonal, but alike in both "
          "senses and at every feed.",
      .words = {.plot = "Ball-bar: an oval at 45 degrees that flips to 135 when the "
                        "sense is reversed.",
                .values = "m v: 1 to 30 um over the usual feeds.",
                .cause = "Servo gains (or input shaping, smoothing, friction) that "
                         "differ between X and Y.",
                .effect = "Circles are oval at speed and round when slow.",
                .action = "Match the position-loop gains, lower the slower axis' lag, "
                          "or cut finishing passes slowly."},
      .neutral = Neutral,
      .sight = Sight{.shown = ShownIn}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    const Vec3<double> velocity_mm_s = CirclingVelocity_mm_s(asked.at);
    const T half_s = SFromMs(asked.p[0]) / 2.0;
    errors->motion_mm[0] += half_s * velocity_mm_s[0];
    errors->motion_mm[1] -= half_s * velocity_mm_s[1];
  }
};

}  // namespace caltwin
