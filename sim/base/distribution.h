#pragma once

#include <string>
#include <variant>

#include "sim/base/rng.h"

namespace caltwin {

struct Normal {
  double mean = 0;
  double sd = 1;
};
struct Uniform {
  double min = 0;
  double max = 1;
};
/// exp of a normal: 68 % lie in median/factor .. median*factor.
struct LogNormal {
  double median = 1;
  double factor = 1;
};

/// A number, or what a number is drawn from.
using Distribution = std::variant<double, Normal, Uniform, LogNormal>;

/// One value; a plain number is itself and draws nothing.
double Draw(const Distribution& distribution, Rng* rng);

/// How much of what it draws lies below `min` and above `max`, each 0 .. 1; of a plain
/// number none.
struct ShareBeyond {
  double below = 0, above = 0;
};
ShareBeyond Beyond(const Distribution& distribution, double min, double max);

/// The middle: mean, mid-range, median; a plain number itself.
double Middle(const Distribution& distribution);

}  // namespace caltwin
