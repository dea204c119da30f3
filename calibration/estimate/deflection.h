#pragma once

#include "calibration/estimate/uncertain.h"

namespace caltwin {

/// Faces that look away from each other (a block) or at each other (a bore).
enum class SpanKind { kExternal, kInternal };

/// A certified size between two faces, touched from both, and what the firmware
/// believed meanwhile.
struct DeflectionSpan {
  SpanKind kind = SpanKind::kExternal;
  Given size_mm{};  ///< Certified.
  Given span_mm{};  ///< After tip compensation by tip_radius_cfg_mm, nothing else.
  double tip_radius_cfg_mm = 0;
  Given tip_radius_mm{};                  ///< Built; from a calliper on the ball.
  Given backlash_mm{};                    ///< Left after the firmware's compensation.
  Given mm_per_commanded_mm{.value = 1};  ///< k: configured over true steps/mm.
};

/// Pre-travel of a probe, and the combination that a span tells without being told
/// backlash and tip.
struct Deflection {
  Uncertain pretravel_mm{};
  /// delta + b / 2 - R, always known where the span is.
  Uncertain combination_mm{};
};

/// delta = R - b / 2 + g (D - k (S + 2 g R_cfg)) / 2, g = +1 external, -1 internal.
///
/// From S = (D + 2 R - 2 delta - b) / k - 2 R_cfg and its internal mirror: the machine
/// moves on by delta after contact, so a block reads small and a bore large. Both tell
/// the same combination; the pre-travel needs b and R from elsewhere.
Deflection DeflectionFromSpan(const DeflectionSpan& span);

/// (S - D) / 2: NeXT 2.2 and 3.6. The sign is wrong for a block; tip and residual
/// backlash are left out.
Uncertain DeflectionAsPublished(const DeflectionSpan& span);

}  // namespace caltwin
