#pragma once

#include "calibration/kinds/delta/bench.h"
#include "calibration/kinds/delta/g33_grid.h"
#include "sim/link/gcode.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {

/// How much G33 prints (V).
enum class G33Verbosity { kDryRun, kEnds, kIterations, kResults };

/// G33 with its letters.
struct G33Options {
  int points = 4;                 ///< P: the grid, 0 to 10.
  double precision_mm = 0;        ///< C: done once the deviation is that small.
  bool tower_angles = true;       ///< False with T.
  int force_iterations = 0;       ///< F: so many at least, 0 to 30; the best is kept.
  double reduce_mm = 0;           ///< R: taken off the calibration radius.
  bool engages_probe = false;     ///< E: stows it after each touch; costs time alone.
  bool probes_at_offset = false;  ///< O: see `probe_offset_mm`.
  G33Verbosity verbosity = G33Verbosity::kEnds;
  double printable_radius_mm = 100;
  double margin_mm = 0;  ///< Kept from the edge.
  /// M851: of the tip from the nozzle. What it is aside and the margin are taken off
  /// the radius, with O the larger of both.
  Vec3<double> probe_offset_mm = Vec3<double>::Zero();
  G33Variant variant = G33Variant::kCorrected;
};

/// G33's letters C E F O P R T V over what is given; others are none of its, as Marlin
/// has it. Throws InputError with Marlin's words where one is implausible.
G33Options ReadG33(const GcodeCommand& command, G33Options options);

/// Marlin's G33: touches a grid, multiplies the seven heights by the normalised
/// inverted displacement matrix, and again, until the deviation from the zero plane
/// (rms of the points used, in whole micrometres) is no longer below the mean of the
/// last two; then the settings with the smallest deviation come back. At most 31 times.
///
/// Its model is three rods of the settings' lengths, one radius, three angles that sum
/// to nought. `said_mm` is that smallest deviation: in sample, of seven averages, blind
/// to what the split averages out. `messages`: its trace. M666's endstops, as Marlin
/// prints them, are never above 0: with `endstop_mm` = height - M666, the published
/// text's (smallest zero) are their negative. Without O the nozzle goes to each point
/// of the grid and the tip, where it stands off it, touches beside; with O the tip
/// does.
DeltaOutcome CalibrateG33(const DeltaProbe& probe,
                          const DeltaModel<double>& start,
                          const G33Options& options = {});

}  // namespace caltwin
