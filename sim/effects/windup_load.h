#pragma once

#include "sim/base/units.h"
#include "sim/effects/drive.h"
#include "sim/effects/effect.h"

namespace caltwin {

/// The drive winds up under the force it needs: finite stiffness with rail friction.
///
///   actual - commanded = -s F c / 2,  lost motion at a reversal = F c   [mm]
///
/// F the axial load (the rail's own friction where none is told), c the compliance. A
/// reversal swings the force from +F to -F, so as a spring in series with the screw its
/// stiffness is k = 2 / c.
struct WindupLoad {
  static constexpr std::array<std::string_view, 3> kAxes = {"x", "y", "z"};
  static constexpr std::array kParameters = {
      Parameter{.name = "compliance_um_per_n",
                .unit = "um/N",
                .min = 0,
                .max = 50,
                .prior = LogNormal{.median = 0.5, .factor = 3},
                .doc = "Lost motion at a reversal per newton of load."}};
  static void Neutral(const Machine&, std::string_view, std::span<double> values) {
    values[0] = 0;
  }
  static Shown In(std::string_view axis) {
    const std::string name(axis);
    return {.channel = name, .covariates = {"load", "dir_" + name}};
  }
  static constexpr Effect kDeclaration = {
      .name = "windup_load",
      .about =
          "The drive gives way under the force that moves the carriage, so it lags.",
      .bucket = Bucket::kMotion,
      .stage = Stage::kDrive,
      .axes = kAxes,
      .parameters = kParameters,
      .formula = "actual - commanded = -s F c / 2",
      .source =
          "Series stiffness of screw, nut and bearings; 10 to 100 N/um for ball "
          "screws, 1 to 10 for belts and plastic nuts.",
      .twin = "backlash: the same at one load; two loads tell.",
      .words = {.plot = "Reversal error against load: a line through zero.",
                .values = "Its slope: 0.02 to 5 um/N.",
                .cause = "Thin screw, belt, soft nut or bearing mount; stiff rails.",
                .effect = "Reversal error that grows with cutting force and dirt.",
                .action =
                    "Clean and grease the rails, stiffen the mount; M425 fits one "
                    "load only."},
      .neutral = Neutral,
      .sight = Sight{.shown = In}};

  template <typename T>
  static void Add(const Asked<T>& asked, Errors<T>* errors) {
    const Drive drive = DriveNamed(asked.axis).value();
    const double load_n = Known(asked.at.load_n)
                              ? asked.at.load_n
                              : asked.machine.axes[drive.slot()].rail_friction_n;
    errors->lost_motion_mm[drive.index] += MmFromUm(asked.p[0]) * load_n;
  }
};

}  // namespace caltwin
