#pragma once

#include <algorithm>

#include "sim/base/units.h"
#include "sim/effects/effect.h"

namespace caltwin {

/// An artefact is larger or smaller than its certificate says, by as much in every
/// size.
///
///   side face: +error / 2 along its outward normal; bore, pocket: -error / 2
///   top face, from the table: +error   [mm]
///
/// The axis is the artefact's id. A face seen from below (a ledge's) does not move: its
/// thickness grows upwards. Oblique faces share by the squares of their normal's parts.
struct BlockSize {
  static constexpr std::array<std::string_view, 1> kAxes = {kAnyAxis};
  static constexpr std::array kParameters = {
      Parameter{.name = "error_um",
                .unit = "um",
                .min = -5000,
                .max = 5000,
                .prior = Normal{.mean = 0, .sd = 25},
                .doc = "True size minus the size entered, alike for every size of the "
                       "artefact."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
  }
  static Shown ShownIn(std::string_view) {
    return {.channel = "bed", .covariates = {"theta"}};
  }
  static constexpr Effect kDeclaration = {
      .name = "block_size",
      .about = "An artefact is not the size that was entered for it.",
      .bucket = Bucket::kArtefact,
      .stage = Stage::kArtefact,
      .axes = kAxes,
      .parameters = kParameters,
      .formula = "face += error / 2 (inside: - error / 2; top: + error)",
      .source =
          "1-2-3 blocks are sold to 2.5 to 10 um but worn and nicked to 20 um; "
          "a size typed wrong reaches 100 um; a calliper resolves 10 um.",
      .twin =
          "steps_per_mm: a wrong scale looks the same on one artefact; a second "
          "one of another size (or a gauge) separates them: the scale's error "
          "grows with length. probe_pretravel: bores and blocks disagree.",
      .words = {.plot = "Span measured minus span entered, one point an artefact: one "
                        "stands apart.",
                .values = "5 to 100 um, the same on all sizes of that artefact, "
                          "beyond three times its stated uncertainty.",
                .cause = "Wear, dirt, paint, a wrong certificate, a size mistyped.",
                .effect = "Poisons the calibration: the machine is adjusted to a "
                          "wrong length.",
                .action = "Clean it, measure it with a micrometer, and repeat with a "
                          "second artefact before changing a setting."},
      .neutral = Neutral,
      .sight = Sight{.shown = ShownIn}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    const At& at = asked.at;
    if (!at.on_table || at.artefact != asked.axis) return;
    const double side = (at.n[0] * at.n[0] + at.n[1] * at.n[1]) / 2;
    const double up = std::max(at.n[2], 0.0);
    const double share = at.inside ? -side : side + up * up;
    errors->artefact_mm += share * MmFromUm(asked.p[0]);
  }
};

}  // namespace caltwin
