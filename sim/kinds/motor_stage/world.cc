#include "sim/kinds/motor_stage/world.h"

#include <string>

#include "sim/base/require.h"

namespace caltwin {
namespace {

int JointOf(const mjModel* model, const std::string& name) {
  return mj_name2id(model, mjOBJ_JOINT, name.c_str());
}

}  // namespace

MotorStageWorld::MotorStageWorld(ModelPtr model, const BuiltMotors& motors)
    : model_(std::move(model)), data_(mj_makeData(model_.get())) {
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    const int motor = JointOf(model_.get(), MotorAxisName(i) + "_motor");
    const int carriage = JointOf(model_.get(), MotorAxisName(i));
    if (motor < 0 || carriage < 0) continue;
    motor_qpos_[i] = model_->jnt_qposadr[motor];
    motor_dof_[i] = model_->jnt_dofadr[motor];
    carriage_qpos_[i] = model_->jnt_qposadr[carriage];
    carriage_dof_[i] = model_->jnt_dofadr[carriage];
    si_per_unit_[i] = motors[i].drawing.si_per_unit();
  }
}

void MotorStageWorld::Place(std::size_t axis, double motor_unit, double carriage_unit) {
  data_->qpos[motor_qpos_[axis]] = motor_unit * si_per_unit_[axis];
  data_->qpos[carriage_qpos_[axis]] = carriage_unit * si_per_unit_[axis];
  data_->qvel[motor_dof_[axis]] = 0;
  data_->qvel[carriage_dof_[axis]] = 0;
}

void MotorStageWorld::SetForce(std::size_t axis, double force) {
  data_->qfrc_applied[motor_dof_[axis]] = force;
}

void MotorStageWorld::Step() {
  mj_step(model_.get(), data_.get());
  for (const mjWarningStat& warning : data_->warning) {
    Require(warning.number == 0, "MuJoCo warns: the simulation is not to be trusted");
  }
}

double MotorStageWorld::MotorAt(std::size_t axis) const {
  return data_->qpos[motor_qpos_[axis]] / si_per_unit_[axis];
}

double MotorStageWorld::MotorSpeed_unit_s(std::size_t axis) const {
  return data_->qvel[motor_dof_[axis]] / si_per_unit_[axis];
}

double MotorStageWorld::CarriageSpeed_unit_s(std::size_t axis) const {
  return data_->qvel[carriage_dof_[axis]] / si_per_unit_[axis];
}

double MotorStageWorld::CarriageAt(std::size_t axis) const {
  return data_->qpos[carriage_qpos_[axis]] / si_per_unit_[axis];
}

}  // namespace caltwin
