#pragma once

#include <optional>
#include <vector>

#include "calibration/kinds/motor_stage/doing.h"

namespace caltwin {

/// Which switch is looked at, how fast the axis came to stand beyond it, and how fast
/// it comes again.
struct SwitchSeek {
  std::size_t axis = 0;
  int sense = -1;  ///< Of the way to it.
  double came_unit_s = 0;
  double fine_unit_s = 0;
};

/// Where a switch was seen to be passed, again and again [pulses].
struct SwitchLooks {
  std::vector<double> at_pulses{};
  /// Of one look [mm, deg]: as drawn (SwitchSigma), or as seen where that is more.
  double sigma_unit = 0;
  bool is_seen = false;   ///< It is what was seen.
  bool scatters = false;  ///< Clearly more than drawn.
  /// From where it opened to where the next look begins: beyond where it may close
  /// next.
  double clear_unit = 0.3;
  std::vector<Contribution> drawn{};

  double mean_pulses() const;
  double mean_sd_unit() const;
  /// What the mean's uncertainty is made of.
  std::vector<Contribution> Budget() const;
};

/// Looks once more: back until the switch is open, on until it is seen, less how late.
bool LookAtSwitch(const SwitchSeek& seek,
                  double pulses_per_unit,
                  SwitchLooks* looks,
                  MotorDoing* doing);

/// Looks `times` times, then compares the looks with each other. What they scatter by
/// counts where it is more than drawn (with n - 1 degrees of freedom). Where
///
///   sum (p_i - mean)^2 / sigma^2
///
/// is beyond chi-squared of n - 1 with 99.99 %, the switch scatters more than drawn; it
/// is looked at anew from far enough for that, warned of, and what was seen is stated.
std::optional<SwitchLooks> LookFinely(const SwitchSeek& seek,
                                      int times,
                                      double pulses_per_unit,
                                      MotorDoing* doing);

}  // namespace caltwin
