#pragma once

#include <span>

#include "scenarios/keys.h"

namespace caltwin {

/// What `caltwin explain` says of a triple-Z printer's procedures.
std::span<const Word> TripleZProcedureWords();

}  // namespace caltwin
