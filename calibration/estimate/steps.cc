#include "calibration/estimate/steps.h"

#include <cmath>

#include "calibration/estimate/expanded.h"

namespace caltwin {
namespace {

// A number and what its uncertainty is made of.
struct Part {
  double value = 0;
  std::vector<Contribution> inputs{};

  double sd() const { return Expand(inputs).u; }
};

// numerator / denominator times a constant, to first order in both; not identifiable
// where an input is not known or the denominator is no larger than its own noise.
Uncertain Ratio(double factor, const Part& numerator, const Part& denominator) {
  if (!std::isfinite(numerator.sd()) || !std::isfinite(denominator.sd())) return {};
  if (std::abs(denominator.value) <= 3 * denominator.sd()) return {};
  if (std::abs(numerator.value) <= 3 * numerator.sd()) return {};
  const double ratio = numerator.value / denominator.value;
  std::vector<Contribution> budget;
  for (Contribution input : numerator.inputs) {
    ScaleInput(factor / denominator.value, &input);
    budget.push_back(input);
  }
  for (Contribution input : denominator.inputs) {
    ScaleInput(-factor / denominator.value * ratio, &input);
    budget.push_back(input);
  }
  return WithBudget(factor * ratio, std::move(budget));
}

Part Difference(const std::string& of, const Given& a, const Given& b) {
  return {.value = a.value - b.value,
          .inputs = {InputOf(of, 1, a), InputOf(of, -1, b)}};
}

}  // namespace

Uncertain StepsFromMove(const MeasuredMove& move) {
  return Ratio(move.steps_per_mm,
               {.value = move.commanded_mm},
               {.value = move.actual_mm.value,
                .inputs = {InputOf("readings", 1, move.actual_mm)}});
}

Uncertain StepsFromTwoSpans(const TwoSpans& spans) {
  const Part measured = Difference("readings", spans.span2_mm, spans.span1_mm);
  const Part certified = Difference("sizes", spans.size2_mm, spans.size1_mm);
  return Ratio(spans.steps_per_mm, measured, certified);
}

Uncertain StepsFromTwoSpansAsPublished(const TwoSpans& spans) {
  return Ratio(spans.steps_per_mm,
               Difference("sizes", spans.size2_mm, spans.size1_mm),
               Difference("readings", spans.span2_mm, spans.span1_mm));
}

Uncertain StepsFromOneSpan(const OneSpan& span) {
  const double radii = 2.0;
  const Part commanded{.value = span.span_mm.value + radii * span.tip_radius_cfg_mm,
                       .inputs = {InputOf("readings", 1, span.span_mm)}};
  const Part gone{.value = span.size_mm.value + 2 * span.tip_radius_mm.value -
                           2 * span.pretravel_mm.value - span.backlash_mm.value,
                  .inputs = {InputOf("sizes", 1, span.size_mm),
                             InputOf("tip radius", 2, span.tip_radius_mm),
                             InputOf("pre-travel", -2, span.pretravel_mm),
                             InputOf("gap", -1, span.backlash_mm)}};
  return Ratio(span.steps_per_mm, commanded, gone);
}

Uncertain StepsFromOneSpanAsPublished(const OneSpan& span) {
  const Part cleaned{.value = span.span_mm.value - 2 * span.pretravel_mm.value -
                              span.backlash_mm.value,
                     .inputs = {InputOf("readings", 1, span.span_mm),
                                InputOf("pre-travel", -2, span.pretravel_mm),
                                InputOf("gap", -1, span.backlash_mm)}};
  return Ratio(
      span.steps_per_mm,
      {.value = span.size_mm.value, .inputs = {InputOf("sizes", 1, span.size_mm)}},
      cleaned);
}

}  // namespace caltwin
