#pragma once

#include "sim/base/units.h"
#include "sim/effects/drive.h"
#include "sim/effects/effect.h"

namespace caltwin {

/// How far off a homing session stands in standard deviations: a standard normal number
/// that belongs to the session's id and the axis, the same in every run.
double HomingDeviate(std::string_view home, std::string_view axis);

/// The homing switch does not close at the same place every time.
///
///   actual - commanded = sd N(home, axis)   [mm]
///
/// N standard normal, one number for each homing session and axis: constant until the
/// next homing. Positive: the axis stands further to + throughout the session.
struct HomingScatter {
  static constexpr std::array<std::string_view, 3> kAxes = {"x", "y", "z"};
  static constexpr std::array kParameters = {
      Parameter{.name = "sd_um",
                .unit = "um",
                .min = 0,
                .max = 5000,
                .prior = LogNormal{.median = 10, .factor = 2.5},
                .doc = "Standard deviation between homings."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
  }
  static Shown In(std::string_view axis) {
    return {.channel = std::string(axis), .covariates = {"t"}};
  }
  static constexpr Effect kDeclaration = {
      .name = "homing_scatter",
      .about = "The axis's zero is a little elsewhere after each homing.",
      .bucket = Bucket::kTime,
      .stage = Stage::kDrive,
      .axes = kAxes,
      .parameters = kParameters,
      .formula = "actual - commanded = one N(0, sd) for each homing",
      .source =
          "Repeatability of homing switches: 10 to 50 um lever switches, 5 to 20 um "
          "inductive, 1 to 5 um optical or slow second touch; without an index pulse a "
          "stepper may also settle one full step aside.",
      .twin =
          "trigger_scatter: differs from touch to touch; a datum touched repeatedly "
          "within a homing and after re-homing tells. missed_steps: one jump only.",
      .words =
          {.plot = "Residual against time: a level for each homing, all different.",
           .values = "Standard deviation of the levels: 5 to 50 um.",
           .cause =
               "Worn or soft switch, homing too fast, dirt, a hot motor that settles "
               "on another microstep.",
           .effect =
               "Work offsets shift after every homing; parts of one session are fine, "
               "parts begun anew do not match.",
           .action = "Home slowly a second time, move the switch near the axis, use an "
                     "index pulse or probe a fixed datum after homing."},
      .neutral = Neutral,
      .sight = Sight{.shown = In}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    DriveError_mm(asked.axis, errors) +=
        MmFromUm(asked.p[0]) * HomingDeviate(asked.at.home, asked.axis);
  }
};

}  // namespace caltwin
