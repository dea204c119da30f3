#pragma once

#include "sim/effects/drive.h"
#include "sim/effects/effect.h"
#include "sim/effects/forms.h"

namespace caltwin {

/// The motor's field does not turn evenly between full steps.
///
///   actual - commanded = A sin(2 pi q / P + phase),  P = travel of 4 full steps   [mm]
///
/// Four full steps are one electrical turn: 0.08 mm with a lead of 4 mm and 200 steps.
/// q is the commanded position; harmonics (the second from unequal phases, the fourth
/// from detent torque) are columns of their own in a diagnosis.
struct Microstep {
  static constexpr std::array<std::string_view, 3> kAxes = {"x", "y", "z"};
  static constexpr std::array kParameters = {
      Parameter{.name = "amplitude_um",
                .unit = "um",
                .min = 0,
                .max = 2000,
                .prior = LogNormal{.median = 2, .factor = 2.5},
                .doc = "Half of peak to peak, of the fundamental."},
      Parameter{.name = "phase_deg",
                .unit = "deg",
                .min = -720,
                .max = 720,
                .prior = Uniform{.min = -180, .max = 180},
                .doc = "Of the wave at commanded position 0.",
                .role = Role::kPhase}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = values[1] = 0;
  }
  static double Period_mm(const AxisDrawing& drawing) {
    return 4 * drawing.lead_mm / drawing.full_steps_per_rev;
  }
  static Shown In(std::string_view axis) {
    return {.channel = std::string(axis), .covariates = {DriveCovariate(axis)}};
  }
  static constexpr Effect kDeclaration = {
      .name = "microstep",
      .about = "The motor's microsteps are not all of the same size.",
      .bucket = Bucket::kMotion,
      .stage = Stage::kDrive,
      .axes = kAxes,
      .parameters = kParameters,
      .formula = "actual - commanded = A sin(2 pi q / (4 full steps) + phase)",
      .source =
          "Step accuracy of hybrid steppers, 5 % of a full step by their data sheets: "
          "1 um with a 4 mm lead, 10 um on a belt of 40 mm per turn; drivers with "
          "offset or wrong decay: twice that.",
      .twin =
          "trigger_scatter: positions on the full-step grid see a constant, any others "
          "seem to scatter; targets off the grid tell.",
      .words =
          {.plot = "Error against position, folded by 4 full steps: one wave.",
           .values = "Amplitude 1 to 10 um; period 0.04 to 0.8 mm.",
           .cause =
               "Unequal phase currents, offset or slow decay of the driver, detent "
               "torque, too little current.",
           .effect =
               "Fine ripple on slow slopes; readings that seem to scatter by a few "
               "micrometres.",
           .action =
               "Tune the driver (offset, decay, current), choose another driver or "
               "motor; more microsteps do not help. Measure at many positions within "
               "4 full steps and average."},
      .neutral = Neutral,
      .sight = Sight{.shown = In, .harmonics = 4}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    const AxisDrawing& drawing = asked.machine.axes[DriveNamed(asked.axis)->slot()];
    DriveError_mm(asked.axis, errors) +=
        Wave_mm(asked.p[0], asked.p[1], DriveAt_mm(asked), T(Period_mm(drawing)));
  }
};

}  // namespace caltwin
