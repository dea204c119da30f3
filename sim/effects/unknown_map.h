#pragma once

#include "sim/base/units.h"
#include "sim/effects/bed_shape.h"
#include "sim/effects/drive.h"
#include "sim/effects/effect.h"
#include "sim/effects/map_table.h"

namespace caltwin {

/// Structure that diagnosis found without a cause that explains it: a table over one or
/// two covariates, carried by the extended machine until somebody names it.
///
///   x y z: actual - commanded += f,  probe: pre-travel += f,  bed: surface += f,
///   nozzle: longer by f [mm]
///
/// f is linear between knots, constant outside them, 0 where a reading does not know a
/// covariate. The axis word holds the channel and the covariates: "z{x,temp}"; without
/// covariates it is one value everywhere. Files give it under `unknown`.
struct UnknownMap {
  static constexpr std::array<std::string_view, 5> kAxes = {
      "x", "y", "z", "probe", "bed"};
  static constexpr std::array<std::string_view, 8> kDeltaAxes = {
      "x", "y", "z", "a", "b", "c", "probe", "bed"};
  static constexpr std::array<std::string_view, 8> kTripleZAxes = {
      "x", "y", "z", "z1", "z2", "z3", "probe", "bed"};
  static constexpr std::array<std::string_view, 3> kStationAxes = {
      "z", "nozzle", "bed"};
  static constexpr std::array kParameters = {
      Parameter{.name = "values_um",
                .unit = "um",
                .min = -10000,
                .max = 10000,
                .prior = Normal{.mean = 0, .sd = 20},
                .doc = "The channel's error at each knot of the covariates."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
  }
  static constexpr Effect kDeclaration = {
      .name = "unknown",
      .about = "Structure without a known cause, as a table over what it follows.",
      .bucket = Bucket::kMotion,
      .stage = Stage::kFrame,
      .axes = kAxes,
      .parameters = kParameters,
      .formula = "channel += f(covariates), linear between knots",
      .source = "What `caltwin diagnose` could not name; the sizes are the data's own.",
      .twin =
          "Every cause in the same covariates; the next campaign that diagnosis "
          "asks for separates them.",
      .words =
          {.plot = "Residual against the covariates named: a trend that no cause of "
                   "the list follows.",
           .values = "As found; the table states each knot's standard deviation.",
           .cause = "Not known: look for what changes with those covariates.",
           .effect = "Predicted and compensated inside the range measured, held "
                     "constant beyond it.",
           .action =
               "Take the measurement that is asked for next, or look at the machine "
               "where the table is steepest."},
      .neutral = Neutral};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    const MapWords words = WordsOf(asked.axis);
    const T value_mm = MmFromUm(MapValue(asked.p, words, asked.at));
    if (DriveNamed(words.channel)) {
      DriveError_mm(words.channel, errors) += value_mm;
    } else if (words.channel == "probe") {
      errors->more_pretravel_mm += value_mm;
    } else if (words.channel == "nozzle") {
      errors->nozzle_mm += value_mm;
    } else {
      AddHeight(asked, value_mm, errors);
    }
  }
};

}  // namespace caltwin
