#pragma once

#include <cmath>

#include "sim/base/units.h"
#include "sim/effects/effect.h"

namespace caltwin {

/// An artefact does not lie square to the axes: it is turned about its own middle,
/// counter-clockwise from above.
///
///   h = n . (tip - middle),  s = across . (tip - middle)   [horizontal parts]
///   face += h (1 - cos a) - s sin a,  inside: -s sin a   [mm]
///
/// exact for plane faces; a bore about its middle does not feel it. The axis is the
/// artefact's id; without one, everything on the table that has an id is turned, each
/// about its own middle. Injected only: a placement absorbs it.
struct BlockRotated {
  static constexpr std::array<std::string_view, 2> kAxes = {"", kAnyAxis};
  static constexpr std::array kParameters = {
      Parameter{.name = "angle_mrad",
                .unit = "mrad",
                .min = -200,
                .max = 200,
                .prior = Normal{.mean = 0, .sd = 3},
                .doc = "Counter-clockwise from above, about the middle of the "
                       "artefact."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
  }
  static constexpr Effect kDeclaration = {
      .name = "block_rotated",
      .about = "An artefact does not lie square to the axes.",
      .bucket = Bucket::kArtefact,
      .stage = Stage::kArtefact,
      .axes = kAxes,
      .parameters = kParameters,
      .formula =
          "face += h (1 - cos a) - s sin a, (h, s) from middle to tip along and "
          "across the normal",
      .source = "Set against a fence: 1 mrad; by eye: 5 to 20 mrad.",
      .twin =
          "squareness C0Y: one face cannot tell; two faces at right angles turn "
          "alike with the block and not with the axis.",
      .words = {.plot = "Side faces against the coordinate along them: lines of one "
                        "slope on all four sides.",
                .values = "Slope: 0.5 to 20 um per mm.",
                .cause = "Laid down by eye, or against a fence with chips behind it.",
                .effect = "Spans measured off their middle read long by 1 / cos; a "
                          "placement in the fit absorbs it.",
                .action = "Touch one face at two places and enter the turn, or align "
                          "the block with a dial."},
      .neutral = Neutral};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    using std::cos;
    using std::sin;
    const At& at = asked.at;
    const bool is_turned =
        asked.axis.empty() ? !at.artefact.empty() : at.artefact == asked.axis;
    if (!at.on_table || !is_turned) return;
    const T angle_rad = RadFromMrad(asked.p[0]);
    const T rx_mm = asked.q_mm[0] + at.probe_off_mm[0] - at.artefact_mid_mm[0];
    const T ry_mm = asked.q_mm[1] + at.probe_off_mm[1] - at.artefact_mid_mm[1];
    const T along_mm = at.n[0] * rx_mm + at.n[1] * ry_mm;
    const T across_mm = at.n[0] * ry_mm - at.n[1] * rx_mm;
    errors->artefact_mm -= sin(angle_rad) * across_mm;
    if (!at.inside) errors->artefact_mm += (1.0 - cos(angle_rad)) * along_mm;
  }
};

}  // namespace caltwin
