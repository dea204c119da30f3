#pragma once

#include "sim/base/units.h"
#include "sim/effects/effect.h"
#include "sim/effects/map_table.h"

namespace caltwin {

/// The axis errs along its travel in no simple shape: a table of it.
///
///   actual - commanded = f(q), linear between knots, constant outside them   [mm]
///
/// q is the commanded position. Positive: the tool stands further to +. In files
/// `knots_mm`, `values_um`, two lists; the effect's values are their MapTable, one
/// value alone being the same everywhere.
struct PitchMap {
  static constexpr std::array<std::string_view, 3> kAxes = {"x", "y", "z"};
  static constexpr std::array kParameters = {
      Parameter{.name = "values_um",
                .unit = "um",
                .min = -5000,
                .max = 5000,
                .prior = Normal{.mean = 0, .sd = 20},
                .doc = "Actual less commanded at each of `knots_mm`."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
  }
  static constexpr Effect kDeclaration = {
      .name = "pitch_map",
      .about = "The error of an axis along its travel, as a table of any shape.",
      .bucket = Bucket::kMotion,
      .stage = Stage::kDrive,
      .axes = kAxes,
      .parameters = kParameters,
      .formula = "actual - commanded = f(q), linear between knots",
      .source =
          "ISO 3408-3: travel deviation of screws, 5 to 50 um over 300 mm; "
          "screw compensation tables of controllers (LinuxCNC, Fanuc) hold it.",
      .twin =
          "cyclic_lead sampled at regular targets: random targets or 2.5 positions "
          "a period tell; pitch_progressive is its smooth bend.",
      .words = {.plot = "Error against position: the same curve in every run, no line, "
                        "no parabola, no wave.",
                .values = "5 to 50 um from peak to valley.",
                .cause = "Screw worn where it works most, a joined rack, a belt whose "
                         "teeth are uneven.",
                .effect = "Lengths are wrong by what the curve differs between their "
                          "ends; steps/mm cannot mend it.",
                .action = "Enter it as the controller's screw compensation table, or "
                          "replace the screw."},
      .neutral = Neutral};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    const MapWords words{
        .channel = asked.axis, .covariates = {asked.axis, ""}, .num_covariates = 1};
    errors->motion_mm[Index(AxisNamed(asked.axis).value())] +=
        MmFromUm(MapValue(asked.p, words, asked.at));
  }
};

}  // namespace caltwin
