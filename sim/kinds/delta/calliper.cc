#include "sim/kinds/delta/calliper.h"

#include "sim/machine/kinds/delta/model.h"

namespace caltwin {

double SimulatedDeltaCalliper::Rod_mm(int rod) {
  const auto at = static_cast<std::size_t>(rod);
  return Read_mm(build_.model.arm_mm[at / 2] + build_.rod_error_mm[at]);
}

std::optional<double> SimulatedDeltaCalliper::Between_mm(const Vec3<double>& from_mm,
                                                         const Vec3<double>& to_mm) {
  const auto from = DeltaPoseOf(build_, from_mm);
  const auto to = DeltaPoseOf(build_, to_mm);
  if (!from || !to) return std::nullopt;
  return Read_mm((to->nozzle_mm - from->nozzle_mm).norm());
}

}  // namespace caltwin
