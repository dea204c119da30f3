#pragma once

#include <optional>

#include "sim/kinds/motor_stage/mechanism.h"
#include "sim/kinds/motor_stage/world.h"

namespace caltwin {

/// Motors in MuJoCo: drives as MotorMechanism has them, all else its own. Each axis is
/// stepped by itself, and not while it rests.
class PhysicsMotors : public MotorMechanism {
 public:
  /// @param model  MJCF of the stage
  PhysicsMotors(const std::filesystem::path& model, const BuiltMotors& motors);

  void Place(std::size_t axis, double motor_unit) override;
  void Tick(const MotorDrives& drives) override;
  MotorState State(std::size_t axis) const override;

 private:
  /// One axis as it is: a model of its own, compiled when it first moves.
  struct AxisNow {
    std::optional<MotorStageWorld> world{};
    double placed_unit = 0;
    bool is_at_rest = false;  ///< The last step changed nothing.
  };
  MotorStageWorld* WorldOf(std::size_t axis);
  void Step(std::size_t axis, double force);
  double InertiaFor(std::size_t axis, bool brakes) const;
  double ServoForce(std::size_t axis, const MotorDrive& drive);
  double StepperForce(std::size_t axis, const MotorDrive& drive);

  SpecPtr spec_;
  std::array<AxisNow, kNumMotorAxes> axes_{};
  std::array<double, kNumMotorAxes> force_{}, field_unit_{};
  std::array<bool, kNumMotorAxes> brakes_{};
};

}  // namespace caltwin
