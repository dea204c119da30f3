#pragma once

#include "sim/kinds/motor_stage/mechanism.h"
#include "sim/kinds/motor_stage/world.h"

namespace caltwin {

/// Motors in MuJoCo: drives as MotorMechanism has them, all else its own.
class PhysicsMotors : public MotorMechanism {
 public:
  /// @param model  MJCF of the stage
  PhysicsMotors(const std::filesystem::path& model, const BuiltMotors& motors);

  void Place(std::size_t axis, double motor_unit) override;
  void Tick(const MotorDrives& drives) override;
  MotorState State(std::size_t axis) const override;

 private:
  double InertiaFor(std::size_t axis, bool brakes) const;
  double ServoForce(std::size_t axis, const MotorDrive& drive);
  double StepperForce(std::size_t axis, const MotorDrive& drive);

  MotorStageWorld world_;
  std::array<double, kNumMotorAxes> force_{}, field_unit_{};
  std::array<bool, kNumMotorAxes> brakes_{};
};

}  // namespace caltwin
