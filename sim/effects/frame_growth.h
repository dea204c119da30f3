#pragma once

#include <cmath>

#include "sim/base/units.h"
#include "sim/effects/effect.h"
#include "sim/effects/forms.h"

namespace caltwin {

/// Spindle head and frame grow after the start and lift the tool.
///
///   dz = growth (1 - exp(-t / tau))   [mm],  t the time in the session [s]
///
/// Positive lifts the tool along z, so touches read -. Needs no temperature log; where
/// rows know no time, their running number stands for seconds.
struct FrameGrowth {
  static constexpr std::array<std::string_view, 1> kAxes = {""};
  static constexpr std::array<std::string_view, 1> kAliases = {"z"};
  static constexpr std::array kParameters = {
      Parameter{.name = "growth_um",
                .unit = "um",
                .min = -5000,
                .max = 5000,
                .prior = Normal{.mean = 0, .sd = 20},
                .doc = "Where it ends, along z; +: lifts the tool."},
      Parameter{.name = "tau_s",
                .unit = "s",
                .min = 0.01,
                .max = 1e7,
                .prior = LogNormal{.median = 1800, .factor = 3},
                .doc = "Time after which 63 % is there; left out: half an hour.",
                .role = Role::kForm}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
    values[1] = 1800;
  }
  static Shown In(std::string_view) { return {.channel = "z", .covariates = {"t"}}; }
  static Forms Grid(const Machine&, std::string_view, const Extent& extent) {
    return OfOne(TimeConstants_s(extent));
  }
  static constexpr Effect kDeclaration = {
      .name = "frame_growth",
      .about = "Spindle head and frame grow after switching on and lift the tool.",
      .bucket = Bucket::kTime,
      .stage = Stage::kFrame,
      .axes = kAxes,
      .parameters = kParameters,
      .formula = "dz = growth (1 - exp(-t / tau)); touches on top read -dz",
      .source =
          "Spindle warm-up tests of ISO 230-3: 5 to 50 um along z with time constants "
          "of 10 min to 2 h on small mills and routers.",
      .twin =
          "probe_temperature: the same on top faces; faces that look up and down and a "
          "temperature log tell. random_walk: no steady approach to an end.",
      .words =
          {.plot = "Height of one datum against time: fast at first, then level.",
           .values = "5 to 50 um, two thirds of it within 10 min to 2 h.",
           .cause = "Spindle bearings and motors warm the head; the column follows.",
           .effect = "Depths drift during a job; heights probed early are wrong later.",
           .action =
               "Warm up with the spindle running until the datum stands still; probe "
               "the height again before finishing."},
      .neutral = Neutral,
      .aliases = kAliases,
      .sight = Sight{.shown = In, .forms = Grid}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    using std::exp;
    errors->motion_mm[2] +=
        MmFromUm(asked.p[0]) * (1.0 - exp(-asked.at.t_s / asked.p[1]));
  }
};

}  // namespace caltwin
