#pragma once

#include <span>

#include "scenarios/keys.h"

namespace caltwin {

/// What `caltwin explain` says of a delta's effects and procedures.
std::span<const Word> DeltaEffectWords();
std::span<const Word> DeltaProcedureWords();

}  // namespace caltwin
