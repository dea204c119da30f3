#pragma once

#include <filesystem>

#include "sim/machine/kinds/motor_stage/built.h"
#include "sim/mjcf/mjcf.h"

namespace caltwin {

/// The MuJoCo model of a motor stage with those motors, mm and deg outside. Names are
/// those of models/motor_stage/model.xml: joints `x_motor` and `x`, body `x`, tendon
/// `x_play`, equality `x_rigid` of every axis; throws InputError where one is missing.
/// @param with_looks  with what is only there to be drawn
ModelPtr CompileMotorStage(const std::filesystem::path& file,
                           const BuiltMotors& motors,
                           double timestep_s,
                           bool with_looks = false);

/// The specification of such a model, its names checked.
SpecPtr ReadMotorStageSpec(const std::filesystem::path& file);
/// The model of one of its axes alone, without looks: axes do not know of each other.
ModelPtr CompileMotorAxis(const mjSpec* stage,
                          std::size_t axis,
                          const BuiltMotor& motor,
                          double timestep_s);

}  // namespace caltwin
