#pragma once

#include "sim/base/units.h"
#include "sim/effects/circling.h"

namespace caltwin {

/// Both axes follow alike but not at once: a circle comes out small.
///
///   dr = -lag (v / 50 mm/s)^2 (100 mm / R)
///
/// R the circle's radius, 100 mm where it is not known; along the outward normal, alike
/// in both senses. A loop of time constant tau has v^2 tau^2 / (2 R).
struct ServoLag {
  static constexpr double kFeed_mm_s = 50;
  static constexpr double kRadius_mm = 100;
  static constexpr std::array<std::string_view, 1> kAxes = {""};
  static constexpr std::array kParameters = {
      Parameter{.name = "lag_um_at_50_mm_s",
                .unit = "um",
                .min = -5000,
                .max = 5000,
                .prior = Normal{.mean = 0, .sd = 10},
                .doc = "How much a circle of 100 mm radius shrinks at 50 mm/s; -: "
                       "grows (feed forward too strong)."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
  }
  static Shown ShownIn(std::string_view) {
    return {.channel = "x", .covariates = {"feed"}};
  }
  static constexpr Effect kDeclaration = {
      .name = "servo_lag",
      .about = "The axes follow late, alike: circles come out small when run fast.",
      .bucket = Bucket::kMotion,
      .stage = Stage::kFrame,
      .axes = kAxes,
      .parameters = kParameters,
      .formula = "dr = -lag (v / 50 mm/s)^2 (100 mm / R)",
      .source =
          "First-order loop: v^2 tau^2 / (2 R), ISO 230-4; tau = 1 ms makes 0.01 "
          "um, 30 ms (gain 33/s, a common servo) 11 um at 50 mm/s on R 100.",
      .twin =
          "steps_per_mm of both axes, or a wrong bar length: alike at every feed; "
          "two feeds separate them.",
      .words = {.plot = "Mean radius of the ball-bar against feed: a falling "
                        "parabola.",
                .values = "1 to 30 um at 50 mm/s on 100 mm radius.",
                .cause = "Low position-loop gain, smoothing or input shaping without "
                         "feed forward.",
                .effect = "Bores milled by interpolation are undersize at speed, the "
                          "more the smaller they are.",
                .action = "Raise the loop gain or add feed forward; slow down on small "
                          "arcs."},
      .neutral = Neutral,
      .sight = Sight{.shown = ShownIn}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    const At& at = asked.at;
    if (at.kind != RowKind::kRadial) return;
    const double radius_mm = at.radius_mm > 0 ? at.radius_mm : kRadius_mm;
    const double v = at.feed_mm_s / kFeed_mm_s;
    const T shrunk_mm = MmFromUm(asked.p[0]) * (v * v * kRadius_mm / radius_mm);
    errors->motion_mm -= shrunk_mm * at.n.template cast<T>();
  }
};

}  // namespace caltwin
