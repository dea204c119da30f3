#pragma once

#include "sim/effects/drive.h"
#include "sim/effects/effect.h"
#include "sim/effects/forms.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {

/// One of the screws under a bed runs ahead and behind once in every turn.
///
///   screw - commanded = A sin(2 pi q / lead + phase),  q its height   [mm]
struct ScrewCyclic {
  static constexpr std::array kParameters = {
      Parameter{.name = "amplitude_um",
                .unit = "um",
                .min = 0,
                .max = 5000,
                .prior = LogNormal{.median = 15, .factor = 2},
                .doc = "Half of peak to peak, of the fundamental."},
      Parameter{.name = "phase_deg",
                .unit = "deg",
                .min = -720,
                .max = 720,
                .prior = Uniform{.min = -180, .max = 180},
                .doc = "Of the wave at the lower endstop.",
                .role = Role::kPhase},
      Parameter{.name = "period_mm",
                .unit = "mm",
                .min = 0.01,
                .max = 1000,
                .prior = LogNormal{.median = 4, .factor = 2},
                .doc = "Travel per turn; left out: the screw's lead as drawn.",
                .role = Role::kForm}};
  static double Lead_mm(const Machine& machine, std::string_view axis) {
    constexpr double kUsual_mm = 4;
    for (const DrawnDrive& drive : machine.kind->Drives(machine)) {
      if (drive.name == axis) return drive.lead_mm;
    }
    return kUsual_mm;
  }
  static void Neutral(const Machine& machine,
                      std::string_view axis,
                      std::span<double> values) {
    values[0] = values[1] = 0;
    values[2] = Lead_mm(machine, axis);
  }
  static Shown In(std::string_view axis) {
    return {.channel = std::string(axis), .covariates = {DriveCovariate(axis)}};
  }
  static Forms Grid(const Machine& machine,
                    std::string_view axis,
                    const Extent& extent) {
    return OfOne(Periods_mm(Lead_mm(machine, axis), DriveSpan_mm(extent, axis)));
  }
  static constexpr Effect kDeclaration = {
      .name = "screw_cyclic",
      .about = "One of the screws under the bed runs ahead and behind once a turn.",
      .bucket = Bucket::kMotion,
      .stage = Stage::kDrive,
      .parameters = kParameters,
      .formula = "screw - commanded = A sin(2 pi q / lead + phase)",
      .source =
          "Bent trapezoidal screws clamped at both ends, eccentric couplings: 5 to 50 "
          "um; the bands on the walls of printed parts show them.",
      .twin =
          "screw_pitch over less than a turn: the wave is a line there; heights at odd "
          "parts of the lead tell.",
      .words = {.plot = "Height near that screw, folded by its lead: one wave a turn.",
                .values = "Amplitude 5 to 50 um; the period is the lead, 2 to 8 mm.",
                .cause =
                    "A bent screw, a coupling off its axis, a nut held too tightly.",
                .effect = "Bands on walls, one a turn, on one side of the part most.",
                .action =
                    "Let the screw's upper end go free, use a coupling that gives, "
                    "straighten or replace the screw."},
      .neutral = Neutral,
      .sight = Sight{.shown = In, .forms = Grid, .harmonics = 4}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    DriveError_mm(asked.axis, errors) +=
        Wave_mm(asked.p[0], asked.p[1], DriveAt_mm(asked), asked.p[2]);
  }
};

}  // namespace caltwin
