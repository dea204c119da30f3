#pragma once

#include <span>
#include <string>
#include <vector>

#include "calibration/estimate/touch_noise.h"
#include "calibration/estimate/uncertain.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// Trigger on the way in and release on the way out of one face, at one feed.
struct TriggerRelease {
  double feed_mm_s = 0;  ///< Of both moves.
  /// Commanded position at the trigger less that at the release, counted along the
  /// inward move; positive. Mean of its repeats.
  Given difference_mm{};
};

/// What the difference of trigger and release is made of.
struct ReleaseFit {
  Uncertain backlash_mm{};
  Uncertain latency_s{};
  /// b + hysteresis, which the readings tell without being told the hysteresis.
  Uncertain combination_mm{};
  double chi2_per_dof = 0;  ///< Of the line over feeds; 0 with two feeds.
};

/// Backlash from trigger against release:  difference = b + hysteresis + 2 v tau.
///
/// Moving in, the carriage lags by b / 2 and the trigger comes late by v tau; moving
/// out it leads by b / 2, the switch opens `hysteresis` below the pre-travel, and the
/// release comes late the other way. The stylus stays deflected meanwhile, so
/// pre-travel, tip and face cancel. Two feeds extrapolate to rest; one feed needs a
/// given latency. Holds only where FrictionHoldsCarriage, and with the firmware's
/// backlash compensation at 0 (it spreads a correction over a longer move than this).
/// Takes commanded for true millimetres: a scale error of 1 % is 1 % of b.
ReleaseFit BacklashFromRelease(std::span<const TriggerRelease> feeds,
                               const Given& hysteresis_mm,
                               const Given& latency_s = kNotGiven);

/// Standard deviation of the mean difference of `pairs` triggers and releases.
double TriggerReleaseSd_mm(const TouchNoise& noise, int pairs);

/// Whether rail friction exceeds the force of the deflected stylus plus what hangs on
/// the nut. Where it does not, the stylus pushes the carriage through its gap, and
/// trigger against release reads the hysteresis alone.
bool FrictionHoldsCarriage(Axis axis,
                           const AxisDrawing& drawing,
                           const ProbeDrawing& probe);

/// Readings of one position by something that is not the motors' counter (dial, laser),
/// approached moving in + and in -:  b = mean(-) - mean(+).
///
/// In + the carriage lags by b / 2, in - it leads. A dial zeroed after the approach in
/// + and read after going on and coming back is this with `plus` = zeros.
Uncertain BacklashFromApproaches(std::span<const double> plus_mm,
                                 std::span<const double> minus_mm,
                                 double reading_sd_mm);

/// The dial's readings after: preload in `sense`, zero, on in `sense`, come back to the
/// same command. reading = sense * b; zeroing has the dial's own noise, so each counts
/// twice.
Uncertain BacklashFromDial(std::span<const double> readings_mm,
                           int sense,
                           double reading_sd_mm);

/// What a published procedure calls backlash although it holds none.
struct Uninformative {
  double value_mm = 0;  ///< As the text computes it.
  double sd_mm = 0;
  /// d value / d b: 0 by construction, so the Fisher information on b is 0 too.
  double sensitivity = 0;
  Uncertain backlash_mm{};  ///< Never identifiable.
  std::string statement{};  ///< Why, for a person.
};

/// Touch, away, touch again in the same sense; |mean(second) - mean(first)|. Two
/// reversals cancel: both touches stand on the same side of the gap.
Uninformative SameSideBacklash(std::span<const double> first_mm,
                               std::span<const double> second_mm,
                               const TouchNoise& noise);

/// Dial zeroed, moved away and returned in the sense it was zeroed in; mean |reading|.
Uninformative AwayReturnBacklash(std::span<const double> readings_mm,
                                 double reading_sd_mm);

}  // namespace caltwin
