#pragma once

#include "calibration/estimate/uncertain.h"

namespace caltwin {

/// Steps/mm of one axis from what a firmware believes and what was measured. In all of
/// them s_true is the steps that move the axis by one true mm, s_cfg the configured
/// ones, k = s_cfg / s_true the mm moved per commanded mm. `_as_published` are the
/// formulas of the seeds, kept to show what they do.

/// One move, and how far the axis truly went (calliper, dial, laser).
struct MeasuredMove {
  double steps_per_mm = 0;  ///< Configured, during the move.
  double commanded_mm = 0;
  Given actual_mm{};
};

/// s_new = s_cfg * commanded / actual, since actual = k * commanded. Not identifiable
/// for a move of nothing. A move that reverses first loses the backlash: lead in.
Uncertain StepsFromMove(const MeasuredMove& move);

/// Two sizes between two faces each, touched with one probe and one setting.
struct TwoSpans {
  double steps_per_mm = 0;  ///< Configured, during all four touches.
  Given size1_mm{};         ///< Certified.
  Given size2_mm{};
  Given span1_mm{};  ///< Measured: distance of the two touches, by the firmware.
  Given span2_mm{};
};

/// s_new = s_cfg * (span2 - span1) / (size2 - size1).
///
/// Touching a size D gives D / k + const, the constant holding pre-travel, backlash and
/// tip radius, so it cancels in the difference. Not identifiable where both sizes are
/// one.
Uncertain StepsFromTwoSpans(const TwoSpans& spans);

/// s_cfg * (size2 - size1) / (span2 - span1): NeXT 3.4, inverted. From 808 (truth 800)
/// it goes to 816, 832, 866: the error doubles each pass.
Uncertain StepsFromTwoSpansAsPublished(const TwoSpans& spans);

/// One external size, and all that stands between it and the span.
struct OneSpan {
  double steps_per_mm = 0;
  Given size_mm{};  ///< Certified.
  Given span_mm{};  ///< After the firmware's tip compensation by tip_radius_cfg_mm.
  double tip_radius_cfg_mm = 0;
  Given tip_radius_mm{};  ///< Built.
  Given pretravel_mm{};
  Given backlash_mm{};  ///< Left after the firmware's compensation.
};

/// s_new = s_cfg (S + 2 R_cfg) / (D + 2 R - 2 delta - b): S + 2 R_cfg is how far the
/// tip's centre was commanded, the denominator how far it went. Not identifiable where
/// radius, pre-travel or backlash is not known.
Uncertain StepsFromOneSpan(const OneSpan& span);

/// s_cfg D / (S - 2 delta - b): NeXT 3.4's alternative, inverted, with wrong signs and
/// without the tip.
Uncertain StepsFromOneSpanAsPublished(const OneSpan& span);

}  // namespace caltwin
