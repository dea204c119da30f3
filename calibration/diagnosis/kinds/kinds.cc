#include "calibration/diagnosis/kinds/kinds.h"

#include <array>

#include "sim/machine/kinds/kinds.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

struct Pair {
  const MachineKind* (*machine)();
  const DiagnosedKind& (*kind)();
};

constexpr std::array kKinds = {Pair{DeltaKind, DiagnosedDelta},
                               Pair{TripleZKind, DiagnosedTripleZ},
                               Pair{ZStationKind, DiagnosedZStation},
                               Pair{CoreXyKind, DiagnosedCoreXy},
                               Pair{CoreXyOnScrewsKind, DiagnosedCoreXyOnScrews}};

}  // namespace

const DiagnosedKind& DiagnosedAs(const Machine& machine) {
  static const DiagnosedKind gantry;
  for (const Pair& one : kKinds) {
    if (one.machine() == machine.kind) return one.kind();
  }
  return gantry;
}

}  // namespace caltwin
