#pragma once

#include <optional>
#include <string_view>

#include "calibration/kinds/delta/bench.h"
#include "calibration/kinds/delta/g33.h"
#include "calibration/kinds/delta/joint.h"
#include "calibration/kinds/delta/steps.h"
#include "calibration/loop/outcome.h"
#include "sim/machine/kinds/delta/model.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// What a procedure on this side of the wire reads the machine through.
struct DeltaDoors {
  DeltaProbe probe{};
  DeltaCalliper calliper{};
};

/// Performs a step that runs on this side of the wire: touches as it likes, ends with
/// settings. `probe_sigma_mm`: of one touch, its counting in steps aside. `fit`: what a
/// joint estimate found beside them.
DeltaOutcome PerformDeltaStep(const DeltaStep& step,
                              double probe_sigma_mm,
                              const Machine& machine,
                              const DeltaDoors& doors,
                              const DeltaModel<double>& start,
                              std::optional<DeltaJointFit>* fit);

/// Which G33 a step asks for: as_published, else corrected.
G33Variant VariantOf(std::string_view variant);

/// What a grid of G33's cannot tell, whatever deviation it prints; none where it tells
/// endstops, radius and angles.
std::optional<Observability> BlindnessOfG33(int points);

}  // namespace caltwin
