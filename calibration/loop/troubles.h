#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calibration/loop/contact_ahead.h"
#include "calibration/loop/probe_reading.h"

namespace caltwin {

/// @file
/// The causes behind the four troubles of the NeXT guide, section 4.4, as far as
/// readings single one out: each function says it in one sentence, with the numbers
/// that tell it, and is empty where nothing does. The guide's own lists are RemedyFor.

/// A probe move that did not end in a touch.
struct FailedProbeMove {
  enum class End {
    kNothingMet,       ///< It came to its target.
    kTriggeredBefore,  ///< It did not begin: the probe already read triggered.
    kBent              ///< The stylus was bent beyond its overtravel.
  };
  End end = End::kNothingMet;
  /// Of the probe afterwards: lifted clear, or (bent) where it stopped.
  ProbeReading after = ProbeReading::kUnknown;
  std::optional<ContactAhead> ahead{};  ///< What the papers have on its way.
  /// Whether the same move was made again after homing, and what it found: how far
  /// behind the expected touch [mm].
  bool was_tried_again = false;
  std::optional<double> found_again_mm{};
};
std::string WhyProbeFailed(const FailedProbeMove& failed);

/// Why repeated touches scatter: one bad touch, two levels, a drift, or no order at
/// all.
/// @param faces_mm  the touches of each face in the order they were made
std::string WhyInconsistent(std::span<const std::vector<double>> faces_mm);

/// Why steps/mm would change by so much: a ratio that another lead, pulley, microstep
/// setting or an inch makes.
/// @param ratio  new over old
std::string WhyUnlikelySteps(double ratio);

/// A pre-travel that no probe has, and what else was read of ball and artefact.
struct UnlikelyPretravel {
  double found_mm = 0;
  double drawn_mm = 0;
  double entered_radius_mm = 0;
  double entered_size_mm = 0;
  std::optional<double> calliper_size_mm{};  ///< Of the artefact.
};
/// Whether it is: below 0, or ten times what is drawn, by more than 3 `sd_mm`.
bool IsUnlikely(const UnlikelyPretravel& pretravel, double sd_mm);
std::string WhyUnlikelyPretravel(const UnlikelyPretravel& pretravel);

/// Why a correction left the machine worse, by the error before and after it, signed
/// alike: a sign reversed, a correction of what was right, one counted twice.
std::string WhyWorse(double before, double after, double sd);

/// How much of a compensation is left over, where more play is compensated than there
/// is; empty where it is not.
/// @param left_mm  gap less compensation, as read by a dial or a laser
std::string WhyTooMuchCompensation(double set_mm, double left_mm);

}  // namespace caltwin
