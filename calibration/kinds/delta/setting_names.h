#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "sim/machine/kinds/delta/model.h"

namespace caltwin {

/// One value of the settings, as the table of results names it: angles in degrees
/// against the drawing, radius and rods the mean of the towers. nullopt: no setting.
std::optional<double> DeltaSettingNamed(const DeltaModel<double>& model,
                                        const DeltaModel<double>& drawn,
                                        std::string_view name);
inline constexpr std::array kDeltaSettingNames = {"endstop.a",
                                                  "endstop.b",
                                                  "endstop.c",
                                                  "delta_radius",
                                                  "tower_angle.a",
                                                  "tower_angle.b",
                                                  "arm_length"};

}  // namespace caltwin
