#include "calibration/procedures/scale_doubt.h"

#include <cmath>

#include "calibration/estimate/expanded.h"

namespace caltwin {
double ScaleDoubt(Session* session, Axis axis, double unmeasured) {
  const auto& known = session->bench().ledger.known;
  const auto found = known.find(NameOf(Setting::kStepsPerMm, axis));
  if (found == known.end()) return unmeasured;
  const double believed = session->Believed(Setting::kStepsPerMm, axis);
  return std::hypot(found->second.sd, found->second.value - believed) / believed;
}

Given ScaleOf(Session* session, Axis axis, double unmeasured) {
  return {.value = 1,
          .sd = ScaleDoubt(session, axis, unmeasured),
          .source = NameOf(Setting::kStepsPerMm, axis),
          .sense = -1};
}

Uncertain WithScaleDoubt(const Uncertain& slope, const Given& along, const Given& z) {
  Uncertain widened = WithInput(slope, InputOf("steps/mm along", -slope.value, along));
  return WithInput(std::move(widened), InputOf("steps/mm of z", slope.value, z));
}

}  // namespace caltwin
