#include "calibration/procedures/catalog.h"

#include <algorithm>
#include <array>

#include "calibration/procedures/cluster_backlash.h"
#include "calibration/procedures/dual_dimension.h"
#include "calibration/procedures/release_backlash.h"

namespace caltwin {

std::span<const Procedure> AllProcedures() {
  static const std::array kAll = {
      kDualDimension, kClusterBacklash, kTriggerReleaseBacklash};
  return kAll;
}

const Procedure* FindProcedure(std::string_view name) {
  const auto all = AllProcedures();
  const auto found = std::ranges::find(all, name, &Procedure::name);
  return found == all.end() ? nullptr : &*found;
}

}  // namespace caltwin
