#include "calibration/estimate/steps.h"

#include <cmath>

#include "sim/base/mutant.h"

namespace caltwin {
namespace {

// numerator / denominator times a constant, to first order in both; not identifiable
// where an input is not known or the denominator is no larger than its own noise.
Uncertain Ratio(double factor, const Given& numerator, const Given& denominator) {
  if (!std::isfinite(numerator.sd) || !std::isfinite(denominator.sd)) return {};
  if (std::abs(denominator.value) <= 3 * denominator.sd) return {};
  if (std::abs(numerator.value) <= 3 * numerator.sd) return {};
  const double ratio = numerator.value / denominator.value;
  return {.value = factor * ratio,
          .sd = std::abs(factor / denominator.value) *
                std::hypot(numerator.sd, ratio * denominator.sd),
          .identifiable = true};
}

Given Difference(const Given& a, const Given& b) {
  return {.value = a.value - b.value, .sd = std::hypot(a.sd, b.sd)};
}

}  // namespace

Uncertain StepsFromMove(const MeasuredMove& move) {
  return Ratio(move.steps_per_mm, {.value = move.commanded_mm}, move.actual_mm);
}

Uncertain StepsFromTwoSpans(const TwoSpans& spans) {
  const Given measured = Difference(spans.span2_mm, spans.span1_mm);
  const Given certified = Difference(spans.size2_mm, spans.size1_mm);
  return Ratio(spans.steps_per_mm,
               Mutant("steps_two_spans_inverted", measured, certified),
               Mutant("steps_two_spans_inverted", certified, measured));
}

Uncertain StepsFromTwoSpansAsPublished(const TwoSpans& spans) {
  return Ratio(spans.steps_per_mm,
               Difference(spans.size2_mm, spans.size1_mm),
               Difference(spans.span2_mm, spans.span1_mm));
}

Uncertain StepsFromOneSpan(const OneSpan& span) {
  const double radii = Mutant("steps_one_span_radius_once", 2.0, 1.0);
  const double sense = Mutant("steps_one_span_pretravel_sign", 1.0, -1.0);
  const Given commanded{.value = span.span_mm.value + radii * span.tip_radius_cfg_mm,
                        .sd = span.span_mm.sd};
  const Given gone{
      .value = span.size_mm.value + 2 * span.tip_radius_mm.value -
               sense * 2 * span.pretravel_mm.value -
               Mutant("steps_one_span_drops_backlash", span.backlash_mm.value, 0.0),
      .sd = std::hypot(std::hypot(span.size_mm.sd, 2 * span.tip_radius_mm.sd),
                       std::hypot(2 * span.pretravel_mm.sd, span.backlash_mm.sd))};
  return Ratio(span.steps_per_mm, commanded, gone);
}

Uncertain StepsFromOneSpanAsPublished(const OneSpan& span) {
  const Given cleaned{
      .value =
          span.span_mm.value - 2 * span.pretravel_mm.value - span.backlash_mm.value,
      .sd = std::hypot(span.span_mm.sd,
                       std::hypot(2 * span.pretravel_mm.sd, span.backlash_mm.sd))};
  return Ratio(span.steps_per_mm, span.size_mm, cleaned);
}

}  // namespace caltwin
