#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calibration/procedures/catalog.h"
#include "calibration/procedures/options.h"

namespace caltwin {

/// How a new compensation is looked at.
enum class GapCheck { kNone, kSpan, kDial, kLaser };

struct ReleaseOptions {
  CommonOptions common{};
  std::vector<double> feeds_mm_s{};  ///< Empty: the probe's slow and fast one.
  std::optional<double> hysteresis_mm{};
  double hysteresis_u_mm = -1;  ///< Below 0: a quarter of the hysteresis.
  std::optional<GapCheck> check{};
  bool statistics = false;  ///< Print clusters as the guide's phase 3 does.
};

/// Backlash of one axis from trigger on the way in against release on the way out, with
/// compensation off; set, and checked by opposite approaches.
Expected<void> RunRelease(Session* session, const ReleaseOptions& options);

/// Reads the options above, the common ones included.
ReleaseOptions ReadReleaseOptions(YamlMap* map, const CommonOptions& defaults);

extern const Procedure kTriggerReleaseBacklash;

}  // namespace caltwin
