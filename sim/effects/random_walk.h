#pragma once

#include "sim/base/units.h"
#include "sim/effects/effect.h"

namespace caltwin {

/// A Brownian path [sqrt(h)]: of variance t in hours, the same in every run: 0 before
/// and at t = 0.
///
/// Built by midpoint displacement (Levy): between two known points the middle is their
/// mean plus a normal number of standard deviation sqrt(length) / 2, which belongs to
/// that middle alone. Over 1024 h, exact at multiples of 0.88 s (2^-22 of that),
/// straight between them; after 1024 h it stands still.
double BrownianPath(double t_s);

/// The height wanders slowly, without reason or end.
///
///   dz = um_per_sqrt_h W(t)   [mm],  W a Brownian path, variance 1 after one hour
///
/// Positive lifts the tool, touches read -. Injected only: every diagnosis has a
/// wandering offset in its baseline, so it is reported there and never a finding.
struct RandomWalk {
  static constexpr std::array<std::string_view, 1> kAxes = {""};
  static constexpr std::array<std::string_view, 1> kAliases = {"z"};
  static constexpr std::array kParameters = {
      Parameter{.name = "um_per_sqrt_h",
                .unit = "um/sqrt(h)",
                .min = 0,
                .max = 5000,
                .prior = LogNormal{.median = 2, .factor = 2},
                .doc = "Standard deviation of the height after one hour."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
  }
  static constexpr Effect kDeclaration = {
      .name = "random_walk",
      .about = "The height wanders slowly, for many small reasons at once.",
      .bucket = Bucket::kTime,
      .stage = Stage::kFrame,
      .axes = kAxes,
      .parameters = kParameters,
      .formula = "dz = size W(t), W a Brownian path with variance 1 after one hour",
      .source =
          "What remains of a drift test (ISO 230-3, environmental variation) in an "
          "unheated shop: 1 to 5 um after one hour, growing with the root of time.",
      .twin =
          "frame_growth: a steady approach to an end; a second run from cold goes the "
          "same way again, a wander does not.",
      .words = {.plot = "Height of one datum against time: wanders, returns, wanders.",
                .values = "1 to 5 um after one hour, twice that after four.",
                .cause = "Draughts, doors, sun, neighbours' machines, relaxing clamps.",
                .effect =
                    "A long campaign is less certain than its repeats say; nothing to "
                    "correct.",
                .action =
                    "Measure in an order that is not the position's, return to a datum "
                    "often, keep campaigns short."},
      .neutral = Neutral,
      .aliases = kAliases};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    errors->motion_mm[2] += MmFromUm(asked.p[0]) * BrownianPath(asked.at.t_s);
  }
};

}  // namespace caltwin
