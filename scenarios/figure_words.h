#pragma once

#include <span>

#include "scenarios/keys.h"

namespace caltwin {

/// What `caltwin explain` says of the figures and quantities that scenarios of motor
/// stages, triple-Z printers and Z offsets print and expect.
std::span<const Word> FigureWords();

}  // namespace caltwin
