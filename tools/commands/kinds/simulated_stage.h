#pragma once

#include "scenarios/kinds/motor_stage_wire.h"
#include "tools/commands/twin_options.h"

namespace caltwin {

/// A simulated motor stage with its controller and a laser on each carriage.
class SimulatedStage {
 public:
  /// Reads the truth file that `named` names: `effects` and `settings` of a motor
  /// stage's scenario. Throws InputError.
  /// @param sigma_unit  standard deviation of one reading of the laser [mm, deg]
  SimulatedStage(const MotorStageDrawing& drawing,
                 const TwinOptions& named,
                 double sigma_unit);

  Link& link() { return wire_; }
  Gauge& gauge() { return gauge_; }

 private:
  SimulatedStage(const MotorStageTruth& truth,
                 const TwinOptions& named,
                 double sigma_unit);

  MotorStageRig rig_;
  Flash flash_{};
  MotorStageFirmware firmware_;
  EmulatedLink wire_;
  MotorStageGauge gauge_;
};

}  // namespace caltwin
