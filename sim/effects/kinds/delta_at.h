#pragma once

#include <optional>
#include <vector>

#include "sim/effects/effect.h"
#include "sim/effects/linkage_at.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {

/// What a delta's reading has beside its pose `q_mm`: the motors that its firmware,
/// with these settings, commands for it (moved on from those that the row states),
/// where the nozzle of that build then is, and its derivatives by every knob. nullopt:
/// the rods do not reach.
std::optional<LinkageAt> LinkageAtOf(const DeltaBuild<double>& build,
                                     const DeltaModel<double>& settings,
                                     const Row& row,
                                     const Vec3<double>& q_mm);

/// How far from the middle the outermost touch lies; 0 where nothing is touched.
double RimOf_mm(const std::vector<Row>& rows);

}  // namespace caltwin
