#pragma once

#include <map>
#include <string>
#include <vector>

#include "sim/effects/effect.h"
#include "sim/effects/surroundings.h"
#include "sim/machine/machine.h"
#include "sim/measure/row.h"

namespace caltwin {

/// One row made ready for the estimate: what Predict_mm needs to know of it, the
/// reading, and what else moved it.
struct Observation {
  At at{};
  double value_mm = 0;
  double sigma_mm = 0;  ///< Of the reading, > 0.
  /// Nuisances, by name, that add coefficient * value: where the artefact lies
  /// ("placement.block.x": n_x), how far a size is off, the switch's hysteresis.
  std::map<std::string, double> nuisances{};
  /// Observations of one group are left out together (HoldOut): a face, a run.
  std::string group{};
};

/// The settings in force by their id (column `settings`); the empty id for rows that
/// name none.
using SettingsById = std::map<std::string, Settings>;

/// How rows become observations.
struct RowUse {
  SettingsById settings{};       ///< An id not in it has the machine's own.
  double default_sigma_mm = 0;   ///< For rows without sigma_mm; > 0.
  bool placement_turns = false;  ///< Let each artefact placement turn about z too.
};

/// The circumstances of one row (AtOf) under the settings it names; an id that is not
/// in `settings`, or none, has the machine's own.
At RowToAt(const Row& row, const Machine& machine, const SettingsById& settings);

/// All rows with their nuisances:
/// - `placement.KEY.x` and y, z: n's components. KEY is the setup, else the artefact
///   (the feature's word before the dot), else the campaign; for gauges the campaign
///   and the setup, since their zero is their own. Where the table holds several
///   settings,
///   `@` and their id follow: a change without homing shifts the machine.
/// - `placement.KEY.turn` [rad, counter-clockwise about the mean touched point], where
///   asked for;
/// - `probe_hysteresis` of a release: the switch opens so much less deflected than it
///   closed.
std::vector<Observation> ObservationsOf(const RowTable& table,
                                        const Machine& machine,
                                        const RowUse& use);

}  // namespace caltwin
