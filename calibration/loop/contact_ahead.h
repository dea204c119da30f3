#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/machine/artefact.h"
#include "sim/machine/axis.h"

namespace caltwin {

/// A straight move that the probe was to end: centres of the tip.
struct ProbeMove {
  Vec3<double> from_mm = Vec3<double>::Zero();
  Vec3<double> target_mm = Vec3<double>::Zero();
  double feed_mm_s = 0;
};

/// The first surface that a probe move would meet by the papers.
struct ContactAhead {
  std::string feature{};  ///< "block.left", "bed.top".
  double after_mm = 0;    ///< From the start of the move to the touch.
  double beyond_mm = 0;   ///< From there to the target; negative: the target is short.
};

/// By nominal places and sizes, for artefacts that lie in the axes, and the table.
/// nullopt: nothing lies on the way, nor on its next 50 mm.
std::optional<ContactAhead> FindContactAhead(const std::vector<Artefact>& artefacts,
                                             const ProbeMove& move,
                                             double tip_radius_mm);

}  // namespace caltwin
