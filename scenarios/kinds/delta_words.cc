#include <array>

#include "scenarios/kinds/delta_scenario.h"

namespace caltwin {

std::span<const Word> DeltaScenario::OwnEffects() const {
  static constexpr std::array kWords = {
      Word{"endstop",
           "endstop.a, .b, .c: {error_mm}. The nozzle stands so much higher than drawn "
           "with that carriage at its endstop. Unequal ones tilt the plane the nozzle "
           "moves in; heights at three places tell."},
      Word{
          "delta_radius",
          "{error_mm}. All tower joints stand further out than drawn: heights become a "
          "bowl. Heights at the middle and on a ring tell; rods of another length look "
          "nearly alike."},
      Word{"tower_angle",
           "tower_angle.a: {angle_deg}. The tower and its joints are turned about the "
           "machine's axis, + counter-clockwise from above. Seen between the towers."},
      Word{"arm_length",
           "{error_mm}. All six rods are longer than believed. Heights come out flat, "
           "prints in the wrong size; a calliper on a rod or on a print tells."},
      Word{
          "bed_tilt",
          "{slope_x_mrad, slope_y_mrad}. The bed rises along +x, +y. Of a delta: a "
          "firmware without tilt in its geometry turns the machine instead, a third of "
          "a millimetre sideways for 2 mrad."},
      Word{"probe_offset",
           "{dx_mm, dy_mm, dz_mm}. The probe's tip from the nozzle; the firmware knows "
           "of "
           "it what M851 says (settings: {probe_offset_mm: [x, y, z]}). dz_mm below 0: "
           "the tip hangs lower than the nozzle."}};
  return kWords;
}

}  // namespace caltwin
