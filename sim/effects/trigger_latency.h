#pragma once

#include "sim/base/units.h"
#include "sim/effects/effect.h"

namespace caltwin {

/// The controller notices the trigger late, and the machine moves on meanwhile.
///
///   touch = ... - v tau   [mm],  v the feed towards the surface
struct TriggerLatency {
  static constexpr std::array<std::string_view, 1> kAxes = {""};
  static constexpr std::array kParameters = {
      Parameter{.name = "latency_ms",
                .unit = "ms",
                .min = 0,
                .max = 100,
                .prior = LogNormal{.median = 0.5, .factor = 3},
                .doc = "From the switch to the step count that is reported."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
  }
  static Shown In(std::string_view) {
    return {.channel = "probe", .covariates = {"feed"}};
  }
  static constexpr Effect kDeclaration = {
      .name = "trigger_latency",
      .about = "The controller notices the trigger late, while the machine moves on.",
      .bucket = Bucket::kMeasurement,
      .stage = Stage::kReadout,
      .axes = kAxes,
      .parameters = kParameters,
      .formula = "touch = ... - v tau",
      .source = "Polled inputs and filters: 0.1 to 5 ms.",
      .twin = "probe_pretravel: the same at one feed; three feeds tell.",
      .words = {.plot = "Touch against feed: a falling line.",
                .values = "Its slope is the latency: 1 ms is 1 um per mm/s.",
                .cause = "Input filter, polling, a slow expander or a wireless probe.",
                .effect = "Pre-travel that depends on the probing feed.",
                .action = "Probe at the feed at which the deflection was measured."},
      .neutral = Neutral,
      .sight = Sight{.shown = In}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    errors->latency_s += SFromMs(asked.p[0]);
  }
};

}  // namespace caltwin
