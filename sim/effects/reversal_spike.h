#pragma once

#include <cmath>

#include "sim/base/units.h"
#include "sim/effects/effect.h"
#include "sim/effects/forms.h"

namespace caltwin {

/// Just after a reversal the axis sticks, then catches up.
///
///   actual - commanded = -s h exp(-d / decay)   [mm]
///
/// s the sense of the last move, d the axis's travel since its last reversal
/// (`since_rev`). Where that is not known nothing is added: a reading far from a
/// reversal does not show it, and one near it cannot be placed.
struct ReversalSpike {
  static constexpr std::array<std::string_view, 3> kAxes = {"x", "y", "z"};
  static constexpr std::array kParameters = {
      Parameter{.name = "height_um",
                .unit = "um",
                .min = -2000,
                .max = 2000,
                .prior = Normal{.mean = 0, .sd = 8},
                .doc = "Right at the reversal; +: the axis lags, -: it jumps ahead."},
      Parameter{.name = "decay_mm",
                .unit = "mm",
                .min = 1e-3,
                .max = 1000,
                .prior = LogNormal{.median = 0.2, .factor = 2.5},
                .doc = "Travel over which it falls to 37 %; left out: 0.2 mm.",
                .role = Role::kForm}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
    values[1] = 0.2;
  }
  static Shown In(std::string_view axis) {
    const std::string name(axis);
    return {.channel = name, .covariates = {"since_rev", "dir_" + name}};
  }
  static Forms Grid(const Machine&, std::string_view, const Extent&) {
    constexpr double kShortest_mm = 0.02, kLongest_mm = 2;
    constexpr int kCount = 7;
    return OfOne(Geometric(kShortest_mm, kLongest_mm, kCount));
  }
  static constexpr Effect kDeclaration = {
      .name = "reversal_spike",
      .about = "Just after a reversal the axis sticks, then catches up.",
      .bucket = Bucket::kMotion,
      .stage = Stage::kDrive,
      .axes = kAxes,
      .parameters = kParameters,
      .formula = "actual - commanded = -s h exp(-d / decay), d since the reversal",
      .source =
          "Reversal spikes of circular tests, ISO 230-4 (quadrant glitches): 1 to 20 "
          "um high, gone after 0.1 to 1 mm.",
      .twin =
          "backlash: does not decay; readings 0.02 to 2 mm after a reversal, or a "
          "ball-bar, tell.",
      .words =
          {.plot =
               "Error against travel since the reversal: a spike that dies away; on a "
               "ball-bar a point at each quadrant.",
           .values = "1 to 20 um, gone within 0.1 to 1 mm.",
           .cause =
               "Static friction of guides or nut, a dry rail, servo gain too low to "
               "break free.",
           .effect =
               "Marks where circles change quadrant; short reversals measure another "
               "backlash than long ones.",
           .action =
               "Lubricate, ease over-tight gibs; on servos tune friction "
               "compensation. Measure backlash more than 2 mm after the reversal."},
      .neutral = Neutral,
      .sight = Sight{.shown = In, .forms = Grid}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    using std::exp;
    const int i = Index(AxisNamed(asked.axis).value());
    const double since_mm = asked.at.since_rev_mm[i];
    if (!Known(since_mm)) return;
    errors->motion_mm[i] -=
        asked.at.dir[i] * MmFromUm(asked.p[0]) * exp(-since_mm / asked.p[1]);
  }
};

}  // namespace caltwin
