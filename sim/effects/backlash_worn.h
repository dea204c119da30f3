#pragma once

#include <cmath>
#include <numbers>

#include "sim/effects/effect.h"
#include "sim/effects/forms.h"

namespace caltwin {

/// The gap is wider where the screw or rack is worn.
///
///   actual - commanded = -s e(q) / 2,  e(q) = extra 2^-((q - center) / (width / 2))^2
///
/// [mm], s the sense of the last move, q the commanded position: a bell of full width
/// `width` at half height, added to the gap that is the same everywhere (`backlash`).
/// Where a hanging weight keeps the gap shut nothing is lost.
struct BacklashWorn {
  static constexpr std::array<std::string_view, 3> kAxes = {"x", "y", "z"};
  static constexpr std::array kParameters = {
      Parameter{.name = "extra_mm",
                .unit = "mm",
                .min = 0,
                .max = 5,
                .prior = LogNormal{.median = 0.02, .factor = 2.5},
                .doc = "By how much the whole gap is wider at the centre."},
      Parameter{.name = "center_mm",
                .unit = "mm",
                .min = -1e5,
                .max = 1e5,
                .prior = Uniform{.min = 0, .max = 300},
                .doc = "Position of the worst wear; left out: mid-travel.",
                .role = Role::kForm},
      Parameter{.name = "width_mm",
                .unit = "mm",
                .min = 0.1,
                .max = 1e5,
                .prior = LogNormal{.median = 80, .factor = 2},
                .doc = "Full width at half height; left out: half the travel.",
                .role = Role::kForm}};
  static void Neutral(const Machine& machine,
                      std::string_view axis,
                      std::span<double> values) {
    const AxisDrawing& drawing = machine.axis(AxisNamed(axis).value());
    values[0] = 0;
    values[1] = drawing.mid_mm();
    values[2] = drawing.travel_mm() / 2;
  }
  static Shown In(std::string_view axis) {
    const std::string name(axis);
    return {.channel = name, .covariates = {name, "dir_" + name}};
  }
  /// Nine centres over the rows' extent, each with five widths. None where rows do not
  /// reach along the axis.
  static Forms Grid(const Machine& machine,
                    std::string_view name,
                    const Extent& extent) {
    constexpr int kNumCentres = 9;
    constexpr double kLeastPartOfTravel = 0.05;
    const Axis axis = AxisNamed(name).value();
    const double span_mm = Span_mm(extent, axis);
    if (span_mm < kLeastPartOfTravel * machine.axis(axis).travel_mm()) return {};
    Forms forms;
    for (int i = 0; i < kNumCentres; ++i) {
      const double centre_mm =
          extent.q_min_mm[Index(axis)] + span_mm * i / (kNumCentres - 1);
      for (const double part : {0.15, 0.2, 0.3, 0.4, 0.6}) {
        forms.push_back({centre_mm, part * span_mm});
      }
    }
    return forms;
  }
  static constexpr Effect kDeclaration = {
      .name = "backlash_worn",
      .about = "The gap is wider where the machine has worked most.",
      .bucket = Bucket::kMotion,
      .stage = Stage::kDrive,
      .axes = kAxes,
      .parameters = kParameters,
      .formula =
          "actual - commanded = -s e(q) / 2, e a bell of height extra and full width "
          "at half height width",
      .source =
          "ISO 230-2 reports the reversal value at each position because it varies; "
          "trapezoidal screws worn in mid-travel: 5 to 100 um more than at the ends.",
      .twin =
          "backlash: the same gap everywhere; the reversal at 11 or more positions "
          "tells. probe_pretravel by sense cannot depend on the position.",
      .words =
          {.plot = "Distance of the two directions against position: a hump.",
           .values = "5 to 100 um above the gap elsewhere, 20 to 200 mm wide.",
           .cause = "Thread, nut or rack worn where most of the work is done, usually "
                    "mid-travel.",
           .effect =
               "No single compensation fits: too little where it is worn, too much "
               "elsewhere.",
           .action =
               "Replace the screw, or turn it end for end. M425 set to the gap where "
               "precise work is done helps there only."},
      .neutral = Neutral,
      .sight = Sight{.shown = In, .forms = Grid}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    using std::exp;
    const Axis axis = AxisNamed(asked.axis).value();
    if (WeightKeepsGapShut(axis, asked.machine.axis(axis))) return;
    const int i = Index(axis);
    const T half_widths = (asked.q_mm[i] - asked.p[1]) / (asked.p[2] / 2.0);
    errors->lost_motion_mm[i] +=
        asked.p[0] * exp(-std::numbers::ln2 * half_widths * half_widths);
  }
};

}  // namespace caltwin
