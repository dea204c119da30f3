#include "sim/effects/homing_scatter.h"

#include <fmt/format.h>

#include "sim/base/rng.h"

namespace caltwin {

double HomingDeviate(std::string_view home, std::string_view axis) {
  return Rng(/*seed=*/0, /*sample=*/0, fmt::format("homing_scatter.{}.{}", axis, home))
      .Normal();
}

}  // namespace caltwin
