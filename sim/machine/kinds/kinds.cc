#include "sim/machine/kinds/kinds.h"

#include <array>

#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

const std::array kKinds = {
    CartesianKind, DeltaKind, TripleZKind, ZStationKind, MotorStageKind, CoreXyKind};

}  // namespace

std::vector<const MachineKind*> AllMachineKinds() {
  std::vector<const MachineKind*> kinds;
  for (const auto kind : kKinds) kinds.push_back(kind());
  return kinds;
}

std::vector<std::string> MachineKindNames() {
  std::vector<std::string> names;
  for (const auto kind : kKinds) names.emplace_back(kind()->name());
  return names;
}

const MachineKind* MachineKindNamed(std::string_view name) {
  for (const auto kind : kKinds) {
    if (kind()->name() == name) return kind();
  }
  return CartesianKind();
}

}  // namespace caltwin
