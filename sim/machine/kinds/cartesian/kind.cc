#include "sim/machine/kinds/cartesian/drawing.h"
#include "sim/machine/kinds/kinds.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

constexpr std::array<std::string_view, 1> kWholeBeam = {""};
// Beside what every cartesian machine has.
constexpr std::array kOfABeam = {KindEffect{"racking", kWholeBeam}};

class Cartesian : public MachineKind {
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

  void ReadDrawing(YamlMap* map, Machine* machine) const override {
    const auto given = map->Optional("beam");
    if (!given) return;
    YamlMap beam = given->Map();
    const auto at = beam.Required("motors_at_x_mm");
    beam.NoMoreKeys();
    if (!at) return;
    constexpr double kFar_mm = 1e5, kLeast_mm = 10;
    const std::size_t faults = at->faults()->size();
    const auto places = at->Numbers(2, {-kFar_mm, kFar_mm});
    if (at->faults()->size() != faults) return;
    if (places[1] - places[0] < kLeast_mm) {
      at->Fail("are not in ascending order, 10 mm or more apart",
               "the motor that is `y` first");
      return;
    }
    machine->kind = GantryOfTwoMotorsKind();
    machine->own = BeamDrawing{{places[0], places[1]}};
  }
};

// Its beam may stand askew.
class GantryOfTwoMotors final : public Cartesian {
 public:
  std::span<const KindEffect> effects() const override { return kOfABeam; }
  bool has_other_effects() const override { return true; }
};

}  // namespace

const MachineKind* CartesianKind() {
  static const Cartesian kind;
  return &kind;
}

const MachineKind* GantryOfTwoMotorsKind() {
  static const GantryOfTwoMotors kind;
  return &kind;
}

}  // namespace caltwin
