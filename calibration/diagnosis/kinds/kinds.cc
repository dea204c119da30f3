#include "calibration/diagnosis/kinds/kinds.h"

#include <array>

#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

struct Named {
  std::string_view name;
  const DiagnosedKind& (*kind)();
};

constexpr std::array kKinds = {Named{"delta", DiagnosedDelta},
                               Named{"triple_z", DiagnosedTripleZ},
                               Named{"z_station", DiagnosedZStation},
                               Named{"corexy", DiagnosedCoreXy}};

}  // namespace

const DiagnosedKind& DiagnosedAs(const Machine& machine) {
  static const DiagnosedKind gantry;
  for (const Named& one : kKinds) {
    if (one.name == machine.kind->name()) return one.kind();
  }
  return gantry;
}

}  // namespace caltwin
