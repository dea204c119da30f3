#pragma once

#include "sim/effects/effect.h"
#include "sim/effects/forms.h"

namespace caltwin {

/// The screw errs once per turn.
///
///   actual - commanded = A sin(2 pi q / P + phase)   [mm]
///
/// q the commanded position (of a touch that at the trigger), P the period: the lead as
/// drawn, unless it is said. The amplitude is half of peak to peak and the
/// fundamental's; harmonics are columns of their own in a diagnosis.
struct CyclicLead {
  static constexpr std::array<std::string_view, 3> kAxes = {"x", "y", "z"};
  static constexpr std::array kParameters = {
      Parameter{.name = "amplitude_um",
                .unit = "um",
                .min = 0,
                .max = 2000,
                .prior = LogNormal{.median = 4, .factor = 2.5},
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
                .max = 1000,
                .prior = LogNormal{.median = 4, .factor = 2},
                .doc = "Travel per turn; left out: the lead as drawn.",
                .role = Role::kForm}};
  static void Neutral(const Machine& machine,
                      std::string_view axis,
                      std::span<double> values) {
    values[0] = values[1] = 0;
    values[2] = machine.axis(AxisNamed(axis).value()).lead_mm;
  }
  static Shown In(std::string_view axis) {
    return {.channel = std::string(axis), .covariates = {std::string(axis)}};
  }
  /// None on a belt: it has no screw.
  static Forms Grid(const Machine& machine,
                    std::string_view name,
                    const Extent& extent) {
    const Axis axis = AxisNamed(name).value();
    const AxisDrawing& drawing = machine.axis(axis);
    if (drawing.is_belt) return {};
    return OfOne(Periods_mm(drawing.lead_mm, Span_mm(extent, axis)));
  }
  static constexpr Effect kDeclaration = {
      .name = "cyclic_lead",
      .about = "The screw runs ahead and behind once in every turn.",
      .bucket = Bucket::kMotion,
      .stage = Stage::kDrive,
      .axes = kAxes,
      .parameters = kParameters,
      .formula = "actual - commanded = A sin(2 pi q / lead + phase)",
      .source =
          "ISO 3408-3, wobble over one turn (peak to peak): 6 um for ball screws of "
          "grade 3, 8 um of grade 5; rolled T8 screws with a bent end or an eccentric "
          "coupling: amplitudes of 5 to 20 um.",
      .twin =
          "pitch_map: with targets at whole turns the wave is the same everywhere or "
          "looks like any bend; random target offsets or a dense run over 2.5 turns "
          "tell. microstep: a period 50 times shorter.",
      .words =
          {.plot = "Error against position, folded by the lead: one wave per turn.",
           .values = "Amplitude 1 to 20 um; the period is the lead, 2 to 10 mm.",
           .cause =
               "Bent screw, coupling off-centre, a bearing that lets the screw move "
               "along once per turn.",
           .effect =
               "Waves on slopes and circles; sizes that depend on where in the turn "
               "they begin and end, so steps/mm calibrated over an odd half turn is "
               "wrong by up to twice the amplitude.",
           .action =
               "Align coupling and bearing, straighten or replace the screw; else a "
               "screw table finer than a quarter of the lead. Calibrate over whole "
               "turns."},
      .neutral = Neutral,
      .sight = Sight{.shown = In, .forms = Grid, .harmonics = 4}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    const int i = Index(AxisNamed(asked.axis).value());
    errors->motion_mm[i] += Wave_mm(asked.p[0], asked.p[1], asked.q_mm[i], asked.p[2]);
  }
};

}  // namespace caltwin
