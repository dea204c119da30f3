#include "calibration/kinds/delta/setting_names.h"

#include <string>

#include "sim/base/units.h"
#include "sim/machine/kinds/delta/model.h"

namespace caltwin {

std::optional<double> DeltaSettingNamed(const DeltaModel<double>& model,
                                        const DeltaModel<double>& drawn,
                                        std::string_view name) {
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string tower = TowerName(static_cast<int>(i));
    if (name == "endstop." + tower) return model.endstop_mm[i];
    if (name == "tower_angle." + tower) {
      return DegFromRad(model.angle_rad[i] - drawn.angle_rad[i]);
    }
  }
  if (name == "delta_radius") return MeanOfTowers(model.radius_mm);
  if (name == "arm_length") return MeanOfTowers(model.arm_mm);
  return std::nullopt;
}

}  // namespace caltwin
