#include "calibration/estimate/deflection.h"

#include <cmath>

#include "calibration/estimate/expanded.h"

namespace caltwin {

Deflection DeflectionFromSpan(const DeflectionSpan& span) {
  const double g = span.kind == SpanKind::kExternal ? 1.0 : -1.0;
  const double centres_mm = span.span_mm.value + g * 2.0 * span.tip_radius_cfg_mm;
  const double k = span.mm_per_commanded_mm.value;
  const double combination_mm = g * (span.size_mm.value - k * centres_mm) / 2;
  std::vector<Contribution> budget{
      InputOf("readings", k / 2, span.span_mm),
      InputOf("sizes", g / 2, span.size_mm),
      InputOf("steps/mm", -g * centres_mm / 2, span.mm_per_commanded_mm)};

  Deflection deflection;
  deflection.combination_mm = WithBudget(combination_mm, budget);
  const double half_backlash_mm = span.backlash_mm.value / 2;
  budget.push_back(InputOf("tip radius", 1, span.tip_radius_mm));
  budget.push_back(InputOf("gap left", -0.5, span.backlash_mm));
  deflection.pretravel_mm = WithBudget(
      span.tip_radius_mm.value - half_backlash_mm + combination_mm, std::move(budget));
  return deflection;
}

Uncertain DeflectionAsPublished(const DeflectionSpan& span) {
  const double sd_mm = std::hypot(span.span_mm.sd, span.size_mm.sd) / 2;
  return {.value = (span.span_mm.value - span.size_mm.value) / 2,
          .sd = sd_mm,
          .identifiable = std::isfinite(sd_mm)};
}

}  // namespace caltwin
