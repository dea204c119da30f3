#pragma once

#include "calibration/diagnosis/observed.h"

namespace caltwin {

/// The settings that the rows were measured with: the only ones their header states,
/// or the machine's.
Settings SettingsOfRows(const Observed& observed);

}  // namespace caltwin
