#include "sim/kinds/motor_stage/mjcf.h"

#include <string>

#include <fmt/format.h>

#include "sim/base/input_error.h"
#include "sim/base/require.h"

namespace caltwin {
namespace {

constexpr double kTwoSided = 0.5, kOneSided = 1;  // Damping ratios.

void CheckNames(const mjSpec* spec, const std::string& file) {
  Faults faults;
  const auto check = [&](mjtObj type, const char* kind, const std::string& name) {
    if (mjs_findElement(spec, type, name.c_str()) != nullptr) return;
    faults.Add({.file = file},
               fmt::format("the model has no {} named '{}'", kind, name),
               "models/motor_stage/model.xml shows the names that caltwin drives");
  };
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    const std::string axis = MotorAxisName(i);
    check(mjOBJ_JOINT, "joint", axis);
    check(mjOBJ_JOINT, "joint", axis + "_motor");
    check(mjOBJ_BODY, "body", axis);
    check(mjOBJ_BODY, "body", axis + "_motor");
    check(mjOBJ_TENDON, "tendon", axis + "_play");
    check(mjOBJ_EQUALITY, "equality", axis + "_rigid");
  }
  faults.ThrowIfAny();
}

void SetLoad(mjsBody* body, const MotorAxisDrawing& drawing) {
  body->explicitinertial = 1;
  if (!drawing.is_rotary) {
    body->mass = drawing.load_inertia;
    return;
  }
  for (mjtNum& inertia : body->inertia) inertia = drawing.load_inertia;
}

void SetAxis(mjSpec* spec,
             const std::string& axis,
             const BuiltMotor& motor,
             double timestep_s) {
  const MotorAxisDrawing& drawing = motor.drawing;
  const double si = drawing.si_per_unit();
  mjs_asJoint(FindElement(spec, mjOBJ_JOINT, axis + "_motor"))->armature =
      drawing.motor_inertia;
  SetLoad(mjs_asBody(FindElement(spec, mjOBJ_BODY, axis)), drawing);
  mjsJoint* carriage = mjs_asJoint(FindElement(spec, mjOBJ_JOINT, axis));
  carriage->frictionloss = drawing.friction;
  carriage->range[0] = motor.lowest_unit() * si;
  carriage->range[1] = motor.highest_unit() * si;
  MakeHard(timestep_s, kOneSided, carriage->solref_limit, carriage->solimp_limit);
  MakeHard(timestep_s, kOneSided, carriage->solref_friction, carriage->solimp_friction);
  mjsTendon* play = mjs_asTendon(FindElement(spec, mjOBJ_TENDON, axis + "_play"));
  const bool has_gap = motor.gap_unit > 0;
  play->limited = has_gap ? mjLIMITED_TRUE : mjLIMITED_FALSE;
  play->range[0] = -motor.gap_unit * si / 2;
  play->range[1] = motor.gap_unit * si / 2;
  MakeHard(timestep_s, kOneSided, play->solref_limit, play->solimp_limit);
  mjsEquality* rigid =
      mjs_asEquality(FindElement(spec, mjOBJ_EQUALITY, axis + "_rigid"));
  rigid->active = has_gap ? 0 : 1;
  MakeHard(timestep_s, kTwoSided, rigid->solref, rigid->solimp);
}

ModelPtr Compiled(mjSpec* spec) {
  ModelPtr model(mj_compile(spec, nullptr));
  Require(model != nullptr,
          fmt::format("the motor stage compiles: {}", mjs_getError(spec)));
  return model;
}

void Remove(mjSpec* spec, mjtObj type, const std::string& name) {
  Require(mjs_delete(spec, FindElement(spec, type, name)) == 0,
          "what CheckNames has found can be taken out");
}

}  // namespace

SpecPtr ReadMotorStageSpec(const std::filesystem::path& file) {
  SpecPtr spec = ReadSpec(file);
  CheckNames(spec.get(), file.string());
  return spec;
}

ModelPtr CompileMotorStage(const std::filesystem::path& file,
                           const BuiltMotors& motors,
                           double timestep_s,
                           bool with_looks) {
  const SpecPtr spec = ReadMotorStageSpec(file);
  spec->option.timestep = timestep_s;
  spec->compiler.discardvisual = with_looks ? 0 : 1;
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    SetAxis(spec.get(), MotorAxisName(i), motors[i], timestep_s);
  }
  return Compiled(spec.get());
}

ModelPtr CompileMotorAxis(const mjSpec* stage,
                          std::size_t axis,
                          const BuiltMotor& motor,
                          double timestep_s) {
  const SpecPtr spec(mj_copySpec(stage));
  spec->option.timestep = timestep_s;
  spec->compiler.discardvisual = 1;
  for (std::size_t i = 0; i < kNumMotorAxes; ++i) {
    if (i == axis) continue;
    const std::string other = MotorAxisName(i);
    Remove(spec.get(), mjOBJ_EQUALITY, other + "_rigid");
    Remove(spec.get(), mjOBJ_TENDON, other + "_play");
    Remove(spec.get(), mjOBJ_BODY, other);
    Remove(spec.get(), mjOBJ_BODY, other + "_motor");
  }
  SetAxis(spec.get(), MotorAxisName(axis), motor, timestep_s);
  return Compiled(spec.get());
}

}  // namespace caltwin
