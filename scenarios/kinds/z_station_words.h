#pragma once

#include <span>

#include "scenarios/keys.h"

namespace caltwin {

/// What `caltwin explain` says of a nozzle's height: its procedures, and the keys of
/// its scenarios that other scenarios do not have.
std::span<const Word> ZStationProcedureWords();
std::span<const Word> ZStationKeyWords();

}  // namespace caltwin
