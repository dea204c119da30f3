#pragma once

#include <array>
#include <memory>

#include "sim/kinds/motor_stage/mjcf.h"
#include "sim/physics/world.h"

namespace caltwin {

/// A compiled motor stage with its state, mm and deg outside, forces in N and N m.
/// Motors get the force they are told; gap, friction, hard stops are MuJoCo's.
class MotorStageWorld {
 public:
  /// `motors`: as the model was given them; axes that it does not have are not asked
  /// for.
  MotorStageWorld(ModelPtr model, const BuiltMotors& motors);

  double timestep_s() const { return model_->opt.timestep; }
  /// Puts motor and carriage there, at rest.
  void Place(std::size_t axis, double motor_unit, double carriage_unit);
  void SetForce(std::size_t axis, double force);
  void Step();

  double MotorAt(std::size_t axis) const;
  double MotorSpeed_unit_s(std::size_t axis) const;
  double CarriageAt(std::size_t axis) const;
  double CarriageSpeed_unit_s(std::size_t axis) const;

  const mjModel* model() const { return model_.get(); }
  mjData* data() const { return data_.get(); }

 private:
  ModelPtr model_;
  std::unique_ptr<mjData, DeleteData> data_;
  /// Where an axis' coordinates stand in MuJoCo's lists; -1: the model has it not.
  struct Places {
    int motor_qpos = -1, motor_dof = -1, carriage_qpos = -1, carriage_dof = -1;
  };
  const Places& Of(std::size_t axis) const;
  std::array<Places, kNumMotorAxes> places_{};
  std::array<double, kNumMotorAxes> si_per_unit_{};
};

}  // namespace caltwin
