#pragma once

#include <string>

#include "calibration/procedures/catalog.h"
#include "calibration/procedures/options.h"
#include "calibration/procedures/release_backlash.h"

namespace caltwin {

struct ClusterOptions {
  ReleaseOptions release{};  ///< For the corrected form, and the common options.
  bool macro = false;        ///< The guide's macro G9100 to the letter.
};

/// NeXT phase 3: statistics of repeated touches. As published: the left face from both
/// sides, gap of the clusters. Corrected: triggers against releases.
Expected<void> RunCluster(Session* session, const ClusterOptions& options);

extern const Procedure kClusterBacklash;

}  // namespace caltwin
