#pragma once

#include "sim/base/units.h"
#include "sim/effects/effect.h"

namespace caltwin {

/// The controller's switch_offset is not the probe's own.
///
///   gap after calibration = ... + (true - configured),  probe on bed the same   [mm]
///
/// The touches shift all alike for ever, which nothing tells from where the bed stands:
/// only a gap measured under the nozzle shows it.
struct SwitchOffset {
  static constexpr std::array<std::string_view, 1> kAxes = {""};
  static constexpr std::array kParameters = {
      Parameter{.name = "off_um",
                .unit = "um",
                .min = -5000,
                .max = 5000,
                .prior = Normal{.mean = 0, .sd = 100},
                .doc = "True less configured; +: the nozzle stands too high by it."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
  }
  static Shown In(std::string_view) { return {.channel = "gap", .covariates = {}}; }
  static constexpr Effect kDeclaration = {
      .name = "switch_offset",
      .about = "The configured switch_offset is not the probe's.",
      .bucket = Bucket::kMeasurement,
      .stage = Stage::kProbe,
      .parameters = kParameters,
      .formula = "gap after calibration = ... + (true - configured)",
      .source =
          "Microswitches release their body 0.4 to 0.7 mm above the trigger, each its "
          "own by some 0.1 mm; set by descending with a feeler gauge.",
      .twin =
          "ooze: the same in the gap; a gap after a calibration with the nozzle wiped "
          "tells. Touches alone show neither apart.",
      .words = {.plot =
                    "Gap under the nozzle after calibration: off by the same, always.",
                .values = "Some 0.05 to 0.2 mm when first set.",
                .cause = "Set by eye, or another switch was put in.",
                .effect = "Every first layer is too high or too low by it.",
                .action = "Add the value found to switch_offset in [z_calibration]."},
      .neutral = Neutral,
      .sight = Sight{.shown = In}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    errors->trigger_mm += MmFromUm(asked.p[0]);
  }
};

}  // namespace caltwin
