#include "calibration/estimate/deflection.h"

#include <cmath>

#include "sim/base/mutant.h"

namespace caltwin {

Deflection DeflectionFromSpan(const DeflectionSpan& span) {
  const double g = span.kind == SpanKind::kExternal
                       ? Mutant("deflection_as_published_sign", 1.0, -1.0)
                       : -1.0;
  const double centres_mm =
      span.span_mm.value +
      g * Mutant("deflection_radius_for_diameter", 2.0, 1.0) * span.tip_radius_cfg_mm;
  const double k = span.mm_per_commanded_mm.value;
  const double combination_mm = g * (span.size_mm.value - k * centres_mm) / 2;
  const double combination_sd_mm =
      std::hypot(std::hypot(span.size_mm.sd, k * span.span_mm.sd),
                 centres_mm * span.mm_per_commanded_mm.sd) /
      2;

  Deflection deflection;
  deflection.combination_mm = {.value = combination_mm,
                               .sd = combination_sd_mm,
                               .identifiable = std::isfinite(combination_sd_mm)};
  const double half_backlash_mm =
      Mutant("deflection_drops_half_backlash", span.backlash_mm.value / 2, 0.0);
  const double sd_mm = std::hypot(std::hypot(combination_sd_mm, span.tip_radius_mm.sd),
                                  span.backlash_mm.sd / 2);
  deflection.pretravel_mm = {
      .value = span.tip_radius_mm.value - half_backlash_mm + combination_mm,
      .sd = sd_mm,
      .identifiable = std::isfinite(sd_mm)};
  return deflection;
}

Uncertain DeflectionAsPublished(const DeflectionSpan& span) {
  const double sd_mm = std::hypot(span.span_mm.sd, span.size_mm.sd) / 2;
  return {.value = (span.span_mm.value - span.size_mm.value) / 2,
          .sd = sd_mm,
          .identifiable = std::isfinite(sd_mm)};
}

}  // namespace caltwin
