#include "sim/machine/kinds/kinds.h"
#include "sim/machine/kinds/motor_stage/drawing.h"
#include "sim/machine/machine_kind.h"

namespace caltwin {
namespace {

// Six motors that do not know of each other.
class MotorStage final : public MachineKind {
 public:
  std::string_view name() const override { return "motor_stage"; }
  std::string_view about() const override {
    return "Six motors that do not know of each other: servos x, y, z and the rotary "
           "a, "
           "open-loop steppers u and v, with limit switches and index pulses. `caltwin "
           "run` "
           "and `calibrate` home and check them by G-code, `serve` is their "
           "controller.";
  }
  std::string_view where() const override { return " of a motor stage"; }
  bool has_tip() const override { return false; }
  bool moves_along_axes() const override { return false; }
  // Its effects are those of its axes (scenarios/kinds/motor_stage_effects.h).
  bool has_other_effects() const override { return false; }

  void ReadDrawing(YamlMap* map, Machine* machine) const override {
    machine->own = ReadMotorStageDrawing(map);
  }
  void ReadAxes(YamlMap* map, Machine* machine) const override {
    auto& drawing = *machine->Own<MotorStageDrawing>();
    drawing.name = machine->name;
    drawing.model = machine->model.empty()
                        ? ShareFolder() / "models/motor_stage/model.xml"
                        : machine->model;
    ReadMotorAxes(map, &drawing);
  }
};

}  // namespace

const MachineKind* MotorStageKind() {
  static const MotorStage kind;
  return &kind;
}

}  // namespace caltwin
