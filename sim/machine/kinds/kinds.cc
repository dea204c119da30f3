#include "sim/machine/kinds/kinds.h"

#include <array>

#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

class Cartesian final : public MachineKind {
 public:
  std::string_view name() const override { return "cartesian"; }
  std::string_view about() const override {
    return "Three axes at right angles, each with a drive of its own, and a probe: a "
           "mill, a"
           " router. `caltwin run` and `calibrate` calibrate one by G-code, `serve` is "
           "one, "
           "`simulate`, `diagnose` and `plan` measure one, `import` reads real ones.";
  }
  bool axes_are_drives() const override { return true; }
  bool touches_with_nozzle() const override { return false; }
};

const std::array kKinds = {
    CartesianKind, DeltaKind, TripleZKind, ZStationKind, MotorStageKind, CoreXyKind};

}  // namespace

const MachineKind* CartesianKind() {
  static const Cartesian kind;
  return &kind;
}

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
