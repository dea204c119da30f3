#include "calibration/procedures/catalog.h"

#include <algorithm>
#include <array>

#include "calibration/kinds/corexy/diagonals.h"
#include "calibration/procedures/cluster_backlash.h"
#include "calibration/procedures/deflection.h"
#include "calibration/procedures/dial_backlash.h"
#include "calibration/procedures/dual_dimension.h"
#include "calibration/procedures/joint_estimate.h"
#include "calibration/procedures/next_all.h"
#include "calibration/procedures/plane_tilt.h"
#include "calibration/procedures/release_backlash.h"
#include "calibration/procedures/rough_steps.h"
#include "calibration/procedures/uninformative_backlash.h"
#include "calibration/procedures/verify.h"

namespace caltwin {

std::span<const Procedure> AllProcedures() {
  static const std::array kAll = {kRoughSteps,
                                  kDualDimension,
                                  kClusterBacklash,
                                  kDeflection,
                                  kVerify,
                                  kNextAll,
                                  kTriggerReleaseBacklash,
                                  kDialBacklash,
                                  kSameSideBacklash,
                                  kAwayReturnBacklash,
                                  kJointEstimate,
                                  kPlaneTilt,
                                  kBeltDiagonals};
  return kAll;
}

const Procedure* FindProcedure(std::string_view name) {
  const auto all = AllProcedures();
  const auto found = std::ranges::find(all, name, &Procedure::name);
  return found == all.end() ? nullptr : &*found;
}

}  // namespace caltwin
