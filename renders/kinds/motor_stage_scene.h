#pragma once

#include "sim/kinds/motor_stage/rig.h"
#include "sim/kinds/motor_stage/world.h"

namespace caltwin {

/// A motor stage's model with looks, every axis where it stands at power-up, drawn
/// once.
class MotorStageScene {
 public:
  /// @param exaggerate  how many times too wide gaps are drawn: each carriage leads its
  ///   motor by half of its own
  MotorStageScene(const BuiltMotorStage& built, double exaggerate);

  const mjModel* model() const { return world_.model(); }
  mjData* data() const { return world_.data(); }

 private:
  MotorStageWorld world_;
};

}  // namespace caltwin
