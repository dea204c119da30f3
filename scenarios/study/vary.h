#pragma once

#include "scenarios/scenario.h"
#include "sim/base/yaml.h"

namespace caltwin {

/// Puts `vary: {NAME: number or distribution}` of a study into a scenario, in place of
/// what it says or beside it. NAME is a parameter as reports call it: cause, axis where
/// it has one, parameter ("backlash.x.gap_mm", "bed_tilt.slope_x_mrad"), or `settings.`
/// with key and axis ("settings.backlash_mm.x", "settings.tip_radius_mm"), or a number
/// of scenarios/varied.h ("instruments.probe.sigma_um"). Faults: names that the
/// scenario's machine cannot have, values out of bounds.
void Vary(YamlMap vary, Scenario* scenario);

}  // namespace caltwin
