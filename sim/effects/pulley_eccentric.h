#pragma once

#include "sim/effects/drive.h"
#include "sim/effects/effect.h"
#include "sim/effects/forms.h"

namespace caltwin {

/// A belt's pulley runs out of true and errs once per turn.
///
///   actual - commanded = A sin(2 pi q / P + phase)   [mm]
///
/// q the commanded position (of a touch that at the trigger), P the travel per turn of
/// the pulley as drawn, unless it is said. A pulley whose teeth are e off its bore has
/// A = e: its effective radius swings by e, and the angle integrates that to a wave of
/// the same height. Harmonics are columns of their own in a diagnosis.
struct PulleyEccentric {
  static constexpr std::array<std::string_view, 3> kAxes = {"x", "y", "z"};
  static constexpr std::array kParameters = {
      Parameter{.name = "amplitude_um",
                .unit = "um",
                .min = 0,
                .max = 5000,
                .prior = LogNormal{.median = 20, .factor = 2},
                .doc = "Half of peak to peak, of the fundamental."},
      Parameter{.name = "phase_deg",
                .unit = "deg",
                .min = -720,
                .max = 720,
                .prior = Uniform{.min = -180, .max = 180},
                .doc = "Of the wave at commanded position 0.",
                .role = Role::kPhase},
      Parameter{.name = "period_mm",
                .unit = "mm",
                .min = 0.01,
                .max = 2000,
                .prior = LogNormal{.median = 40, .factor = 1.5},
                .doc = "Travel per turn; left out: the pulley's as drawn.",
                .role = Role::kForm}};
  static void Neutral(const Machine& machine,
                      std::string_view axis,
                      std::span<double> values) {
    values[0] = values[1] = 0;
    values[2] = machine.axes[static_cast<std::size_t>(DriveNamed(axis)->index)].lead_mm;
  }
  static Shown In(std::string_view axis) {
    return {.channel = std::string(axis), .covariates = {DriveCovariate(axis)}};
  }
  /// None on a screw: it has no pulley.
  static Forms Grid(const Machine& machine,
                    std::string_view name,
                    const Extent& extent) {
    const AxisDrawing& drawing =
        machine.axes[static_cast<std::size_t>(DriveNamed(name)->index)];
    if (!drawing.is_belt) return {};
    return OfOne(Periods_mm(drawing.lead_mm, DriveSpan_mm(extent, name)));
  }
  static constexpr Effect kDeclaration = {
      .name = "pulley_eccentric",
      .about = "The belt's pulley runs out of true, so the axis errs once per turn.",
      .bucket = Bucket::kMotion,
      .stage = Stage::kDrive,
      .axes = kAxes,
      .parameters = kParameters,
      .formula = "actual - commanded = A sin(2 pi q / pulley_mm_per_rev + phase)",
      .source =
          "Run-out of GT2 pulleys held by grub screws: 0.02 to 0.1 mm in total, so "
          "amplitudes of 10 to 50 um; A is half the total run-out.",
      .twin =
          "pitch_map, straightness seen by a ball-bar: one turn is 40 mm with 20 teeth "
          "of 2 mm, so few waves fit the travel; random target offsets and more than "
          "2.5 turns tell.",
      .words =
          {.plot = "Error against position, folded by the pulley's turn: one wave.",
           .values = "Amplitude 10 to 50 um; period 32 to 60 mm.",
           .cause =
               "Pulley bored off-centre or pushed to one side by its grub screw, bent "
               "motor shaft.",
           .effect = "Wide waves on walls; sizes that depend on where they are cut.",
           .action =
               "Replace the pulley by one clamped or pressed on; check its run-out "
               "with a dial: the amplitude is half of what it shows."},
      .neutral = Neutral,
      .sight = Sight{.shown = In, .forms = Grid, .harmonics = 4}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    DriveError_mm(asked.axis, errors) +=
        Wave_mm(asked.p[0], asked.p[1], DriveAt_mm(asked), asked.p[2]);
  }
};

}  // namespace caltwin
