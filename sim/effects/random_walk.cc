#include "sim/effects/random_walk.h"

#include <cmath>
#include <cstdint>

#include "sim/base/rng.h"

namespace caltwin {
namespace {

constexpr int kNumLevels = 22;
constexpr double kHorizon_h = 1024;

// The normal number of one middle: level 0 is the far end, level k has 2^(k-1) middles.
double Deviate(int level, std::uint64_t middle) {
  return Rng(static_cast<std::uint64_t>(level), middle, "random_walk").Normal();
}

}  // namespace

double BrownianPath(double t_s) {
  const double t_h = t_s / SFromH(1.0);
  double left = 0;
  double right = std::sqrt(kHorizon_h) * Deviate(0, 0);
  if (!(t_h > 0)) return left;
  if (t_h >= kHorizon_h) return right;
  double begin_h = 0, length_h = kHorizon_h;
  std::uint64_t index = 0;
  for (int level = 1; level <= kNumLevels; ++level) {
    const double middle =
        (left + right) / 2 + std::sqrt(length_h) / 2 * Deviate(level, index);
    length_h /= 2;
    const bool is_late = t_h >= begin_h + length_h;
    index = 2 * index + (is_late ? 1 : 0);
    if (is_late) begin_h += length_h;
    (is_late ? left : right) = middle;
  }
  return left + (right - left) * (t_h - begin_h) / length_h;
}

}  // namespace caltwin
