#pragma once

#include <filesystem>
#include <optional>

#include "tools/commands/calibrate.h"

namespace caltwin {

/// The motor stage that the link's twin or --machine is; none where it is another
/// machine or none is named.
std::optional<std::filesystem::path> MotorStageToCalibrate(
    const CalibrateOptions& options);

/// `caltwin calibrate` of motor axes. Their procedures home, move and store by nature:
/// a machine wants --apply, which asks before each; a twin is gone afterwards anyway.
int CalibrateMotorsAtHand(const CalibrateOptions& options,
                          const std::filesystem::path& machine);

}  // namespace caltwin
