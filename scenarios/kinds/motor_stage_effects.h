#pragma once

#include <vector>

#include "scenarios/kinds/motor_stage_scenario.h"

namespace caltwin {

/// Reads `effects:` of a motor stage: `switch_scatter.x: {sd_um: 10}`. Lengths of a
/// rotary axis are written `_deg` where linear ones have `_mm`; `_um` of it are
/// thousandths of a degree.
std::vector<MotorEffectSpec> ReadMotorEffects(YamlMap map,
                                              const MotorStageDrawing& drawing);

/// Every effect of a motor stage's axes, for messages.
std::vector<std::string> MotorEffectNames();

/// Builds that number into the stage.
void ApplyMotorEffect(const MotorEffectSpec& spec,
                      double value,
                      BuiltMotorStage* built);

}  // namespace caltwin
