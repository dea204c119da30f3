#include "calibration/diagnosis/known_size.h"

#include <algorithm>
#include <cmath>
#include <string_view>

namespace caltwin {
namespace {

// Not where it stands at the end of what is possible, nor where it (of several sizes
// each) may as well be nothing. What a kelvin does to a material is known: ten times
// the usual is something else.
bool HasSize(const Candidate& candidate, const Refined& refined) {
  if (candidate.cause == "homing_scatter") return true;  // Its size is a scatter.
  constexpr double kLeast_sds = 2;
  constexpr double kAtEnd = 1e-6;
  constexpr double kMostOfUsual = 10;
  const auto parameters = EffectAt(candidate.effect).parameters;
  bool is_something = false;
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    if (parameters[p].role != Role::kSize) continue;
    const double size = refined.effect.values[p];
    const double end = kAtEnd * (parameters[p].max - parameters[p].min);
    is_something |= std::abs(size) >= kLeast_sds * refined.sds[p];
    if (size > parameters[p].max - end) return false;
    if (size < parameters[p].min + end) return false;
    const bool is_per_kelvin = parameters[p].unit.find('K') != std::string_view::npos;
    const double of_usual = refined.sizes_mm.norm() / refined.variant.usual_mm;
    if (is_per_kelvin && of_usual > kMostOfUsual) return false;
  }
  return is_something;
}

// Not where the rows end too early to tell a growth that levels off from a drift with
// no end: its time constant stays within those that they can show.
bool SeesItsEnd(const Candidate& candidate, const Refined& refined) {
  if (candidate.cause != "frame_growth") return true;
  constexpr double kAtEnd = 0.99;
  double longest_s = 0;
  for (const Variant& variant : candidate.variants) {
    longest_s = std::max(longest_s, variant.forms[0]);
  }
  return refined.variant.forms[0] < kAtEnd * longest_s;
}

}  // namespace

bool IsSizeKnown(const Candidate& candidate, const Refined& refined) {
  return HasSize(candidate, refined) && SeesItsEnd(candidate, refined);
}

}  // namespace caltwin
