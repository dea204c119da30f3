#pragma once

#include <limits>

namespace caltwin {

/// An estimated number. Where it is not identifiable, value and sd mean nothing.
struct Uncertain {
  double value = 0;
  double sd = 0;  ///< Standard uncertainty, everything stated included.
  bool identifiable = false;
};

/// A number that an estimate takes from elsewhere, and how well it is known there.
struct Given {
  double value = 0;
  double sd = 0;  ///< 0: exact; infinite: not known at all.
};

/// What nobody has measured yet.
inline constexpr Given kNotGiven{.value = 0,
                                 .sd = std::numeric_limits<double>::infinity()};

/// An estimate as input to the next one: what was not identifiable is not given.
constexpr Given AsGiven(const Uncertain& estimate) {
  if (!estimate.identifiable) return kNotGiven;
  return {.value = estimate.value, .sd = estimate.sd};
}

}  // namespace caltwin
