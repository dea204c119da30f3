#include "calibration/diagnosis/delta_lines.h"

#include <cstddef>

namespace caltwin {

std::vector<KnobTurn<double>> KnobsOfLine(std::string_view name, double value) {
  if (name == "bed_plane.slope_x") return {{kBedKnob, value}};
  if (name == "bed_plane.slope_y") return {{kBedKnob + 1, value}};
  if (name == "scale") {
    return {{kBeltKnob, value}, {kBeltKnob + 1, value}, {kBeltKnob + 2, value}};
  }
  const auto knob = DeltaKnobNamed(name);
  if (!knob) return {};
  if (*knob >= kRadiusKnob) return {{*knob, value}};
  return {{*knob, value}, {kEndstopKnob + 2, -value}};
}

}  // namespace caltwin
