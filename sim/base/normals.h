#pragma once

#include "sim/base/rng.h"

namespace caltwin {

/// A normal number, mean 0 and standard deviation 1, by the ziggurat of 128 layers
/// (Doornik 2005, "An improved ziggurat method to generate normal random samples"):
/// several times faster than Rng::Normal and another number of the same stream. For
/// the inner loops of linear studies.
double QuickNormal(Rng* rng);

}  // namespace caltwin
