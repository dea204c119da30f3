#include "calibration/procedures/scale_doubt.h"

#include <cmath>

namespace caltwin {
namespace {

constexpr double kScaleDoubt = 0.01;  // Of steps/mm nobody has: the catalogue's prior.

}  // namespace

double ScaleDoubt(Session* session, Axis axis) {
  const auto& known = session->bench().ledger.known;
  const auto found = known.find(NameOf(Setting::kStepsPerMm, axis));
  if (found == known.end()) return kScaleDoubt;
  const double believed = session->Believed(Setting::kStepsPerMm, axis);
  return std::hypot(found->second.sd, found->second.value - believed) / believed;
}

Uncertain WithScaleDoubt(const Uncertain& slope, double along_doubt, double z_doubt) {
  Uncertain widened = slope;
  widened.sd = std::hypot(slope.sd, slope.value * along_doubt, slope.value * z_doubt);
  return widened;
}

}  // namespace caltwin
