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
    places_[i] = {.motor_qpos = model_->jnt_qposadr[motor],
                  .motor_dof = model_->jnt_dofadr[motor],
                  .carriage_qpos = model_->jnt_qposadr[carriage],
                  .carriage_dof = model_->jnt_dofadr[carriage]};
    si_per_unit_[i] = motors[i].drawing.si_per_unit();
  }
}

const MotorStageWorld::Places& MotorStageWorld::Of(std::size_t axis) const {
  Require(places_[axis].motor_qpos >= 0, "the model has the axis that is asked for");
  return places_[axis];
}

void MotorStageWorld::Place(std::size_t axis, double motor_unit, double carriage_unit) {
  data_->qpos[Of(axis).motor_qpos] = motor_unit * si_per_unit_[axis];
  data_->qpos[Of(axis).carriage_qpos] = carriage_unit * si_per_unit_[axis];
  data_->qvel[Of(axis).motor_dof] = 0;
  data_->qvel[Of(axis).carriage_dof] = 0;
}

void MotorStageWorld::SetForce(std::size_t axis, double force) {
  data_->qfrc_applied[Of(axis).motor_dof] = force;
}

void MotorStageWorld::Step() {
  mj_step(model_.get(), data_.get());
  for (const mjWarningStat& warning : data_->warning) {
    Require(warning.number == 0, "MuJoCo warns: the simulation is not to be trusted");
  }
}

double MotorStageWorld::MotorAt(std::size_t axis) const {
  return data_->qpos[Of(axis).motor_qpos] / si_per_unit_[axis];
}

double MotorStageWorld::MotorSpeed_unit_s(std::size_t axis) const {
  return data_->qvel[Of(axis).motor_dof] / si_per_unit_[axis];
}

double MotorStageWorld::CarriageSpeed_unit_s(std::size_t axis) const {
  return data_->qvel[Of(axis).carriage_dof] / si_per_unit_[axis];
}

double MotorStageWorld::CarriageAt(std::size_t axis) const {
  return data_->qpos[Of(axis).carriage_qpos] / si_per_unit_[axis];
}

}  // namespace caltwin
