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

Uncertain WithScaleDoubt(const Uncertain& slope, double along_doubt, double z_doubt) {
  const double size = std::abs(slope.value);
  Uncertain widened =
      WithInput(slope, {.input = "steps/mm along", .u = size * along_doubt});
  return WithInput(std::move(widened), {.input = "steps/mm of z", .u = size * z_doubt});
}

}  // namespace caltwin
