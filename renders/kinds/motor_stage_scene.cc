#include "renders/kinds/motor_stage_scene.h"

#include "sim/kinds/motor_stage/mechanism.h"

namespace caltwin {

MotorStageScene::MotorStageScene(const BuiltMotorStage& built, double exaggerate)
    : world_(CompileMotorStage(built.drawing.model,
                               built.motors,
                               MotorMechanism::kTick_s,
                               /*with_looks=*/true),
             built.motors) {
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    const double motor_unit = built.faults[i].start_unit;
    const double lead_unit = exaggerate * built.motors[i].gap_unit / 2;
    world_.Place(i, motor_unit, motor_unit + lead_unit);
  }
  mj_forward(world_.model(), world_.data());
}

}  // namespace caltwin
