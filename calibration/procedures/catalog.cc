#include "calibration/procedures/catalog.h"

#include <algorithm>
#include <array>

#include "calibration/kinds/corexy/diagonals.h"
#include "calibration/kinds/delta/catalog.h"
#include "calibration/kinds/motor_stage/catalog.h"
#include "calibration/kinds/triple_z/catalog.h"
#include "calibration/kinds/z_station/catalog.h"
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
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

bool Suits(const Procedure& procedure, const MachineKind& kind) {
  switch (procedure.drives) {
    case DrivesAsked::kOwn:
      return kind.axes_are_drives();
    case DrivesAsked::kAny:
      return kind.axes_are_drives() || kind.drive_map() != nullptr;
    case DrivesAsked::kCoupled:
      return kind.drive_map() != nullptr;
  }
  return false;
}

}  // namespace

const Procedures& AllProcedures() {
  static const Procedures kAll = [] {
    Procedures all = {&kRoughSteps,
                      &kDualDimension,
                      &kClusterBacklash,
                      &kDeflection,
                      &kVerify,
                      &kNextAll,
                      &kTriggerReleaseBacklash,
                      &kDialBacklash,
                      &kSameSideBacklash,
                      &kAwayReturnBacklash,
                      &kJointEstimate,
                      &kPlaneTilt,
                      &kBeltDiagonals};
    for (const auto of_kind : {DeltaProcedures(),
                               TripleZProcedures(),
                               ZStationProcedures(),
                               MotorProcedures()}) {
      for (const Procedure& procedure : of_kind) all.push_back(&procedure);
    }
    return all;
  }();
  return kAll;
}

Procedures ProceduresFor(const MachineKind& kind) {
  Procedures suiting;
  for (const Procedure* one : AllProcedures()) {
    if (one->kind.empty() && Suits(*one, kind)) suiting.push_back(one);
  }
  return suiting;
}

Procedures ProceduresOf(std::string_view kind) {
  Procedures own;
  for (const Procedure* one : AllProcedures()) {
    if (one->kind == kind) own.push_back(one);
  }
  return own;
}

const Procedure* FindProcedure(std::string_view name, const Procedures& among) {
  const auto found = std::ranges::find(among, name, &Procedure::name);
  return found == among.end() ? nullptr : *found;
}

}  // namespace caltwin
