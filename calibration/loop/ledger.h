#pragma once

#include <map>
#include <string>

#include "calibration/estimate/uncertain.h"
#include "sim/machine/axis.h"
#include "sim/machine/machine.h"
#include "sim/measure/row.h"

namespace caltwin {

/// What the procedures run on one bench leave for the next ones: what rows refer to by
/// id, and what has been estimated.
struct Ledger {
  std::map<std::string, Settings> settings{};  ///< By the id that rows cite.
  std::string settings_now{};                  ///< Id of the last ones written or read.
  int homings = 0;
  /// Sense of each axis's last move; unknown before the first.
  Vec3<double> direction = Vec3<double>::Constant(kUnknown);
  /// The same of each drive, where drives move the axes together.
  Vec3<double> drive_direction = Vec3<double>::Constant(kUnknown);
  /// How often each artefact has been put down anew; part of a row's `setup`.
  std::map<std::string, int> placements{};
  /// Estimates by name ("backlash.x": the whole gap), the last of each.
  std::map<std::string, Uncertain> known{};
};

}  // namespace caltwin
