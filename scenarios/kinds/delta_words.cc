#include "scenarios/kinds/delta_words.h"

#include <array>

namespace caltwin {

std::span<const Word> DeltaEffectWords() {
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

std::span<const Word> DeltaProcedureWords() {
  static constexpr std::array kWords = {
      Word{"g33",
           "Marlin's auto calibration of a delta: a grid of touches becomes seven "
           "heights, those times a normalised inverse matrix become corrections, again "
           "until the deviation no longer falls. Options: p (the grid, 0 to 10), c "
           "(precision), f (rounds at least), r (off the radius), v (0 to 3: how much "
           "it "
           "prints), e, o and t (true: as the letter alone), variant (as_published, "
           "corrected). Its deviation is in sample: P2 says 0.000 and may leave 0.09 "
           "mm."},
      Word{
          "rrf_least_squares",
          "RepRapFirmware's: two Gauss-Newton rounds over 16 touches. Option: factors, "
          "3 endstops, 4 + radius, 6 + angles, 7 + rods, 8 = 6 + bed tilt, 9 = 8 + "
          "rods. Rods from heights alone are known to a quarter of a millimetre. The "
          "tilt "
          "that 8 and 9 find is told and not commanded: Marlin has no setting for it."},
      Word{"klipper_descent",
           "Klipper's DELTA_CALIBRATE: seven touches, six numbers by coordinate "
           "descent. One degree of freedom is left, so its own fit says little. "
           "Option: print (true: twelve distances of a calibration print, read by "
           "calliper, and the three rods are fitted too: nine numbers)."},
      Word{"delta_joint",
           "caltwin's own: all unknowns at once through the exact six-rod chain, with "
           "priors, uncertainties, the error of points left out. Options: points (8 to "
           "400); unknowns (firmware: endstops, radius, angles, tilt; machine: 27 and "
           "the tilt) or fit (a list of any of them, [delta_radius, arm_length]); "
           "priors ({arm_length: {value: 250.4, sd: 0.02}}: what is known beforehand, "
           "a setting's as its value); rods and print (true: each rod, or twelve "
           "distances of a calibration print, are read by calliper, which scatters by "
           "instruments: {calliper: {sigma_um: 20}}); mesh (true: what the settings "
           "leave "
           "is foretold and commanded as a mesh of heights, M421 and M420). Settings "
           "that would change less "
           "than twice what the readings leave open are kept."}};
  return kWords;
}

}  // namespace caltwin
