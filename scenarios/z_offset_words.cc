#include "scenarios/z_offset_words.h"

#include <array>

namespace caltwin {

std::span<const Word> ZOffsetProcedureWords() {
  static constexpr std::array kWords = {
      Word{
          "z_calibration",
          "Klipper's CALIBRATE_Z: the nozzle and the probe's body on the endstop "
          "switch, the probe on the bed; offset = probe - (switch - nozzle + "
          "switch_offset). In scenarios with a `station:`, and by `calibrate --link`."},
      Word{
          "probe_accuracy",
          "PROBE_Z_ACCURACY or PROBE_ACCURACY: maximum, minimum, range, average, "
          "median, standard deviation, and whether a switch is worn. Options: samples, "
          "of (endstop or probe)."},
      Word{
          "switch_offset",
          "The stepwise descent with a feeler gauge (Z5, 3, 1, 0.5, 0.3, 0.1): what "
          "switch_offset should be. corrected wipes the nozzle and calibrates first; "
          "as_published goes by the offset in force, and takes ooze for switch_offset. "
          "Option: apply (true)."}};
  return kWords;
}

std::span<const Word> ZOffsetKeyWords() {
  static constexpr std::array kWords = {
      Word{
          "z_station",
          "A kind of machine: a printer's head over its endstop switch and bed, with a "
          "magnetic switch probe. See docs/z-offset.md."},
      Word{"station",
           "What is true of nozzle, endstop switch, probe and plate: switch_mm "
           "nozzle_mm ooze_mm ooze_flows_c body_mm trigger_mm plate_mm, the bed's "
           "shape, scatter, wear and growth. Numbers or distributions."},
      Word{"ooze_mm",
           "Plastic under the nozzle's tip, as thick as the switch squashes it, from "
           "ooze_flows_c degC on; away once wiped, until the nozzle is heated anew."},
      Word{"trigger_mm",
           "The probe's body over what its knob touches, at the trigger: what "
           "switch_offset should be."},
      Word{"dock_misses", "1: the magnets do not take the probe along."},
      Word{"change", "A step: what an operator changes of the station."},
      Word{"switch_offset_mm",
           "printer.cfg's switch_offset of [z_calibration]: body over what the knob "
           "touches, at the trigger. Not below 0."},
      Word{"samples_tolerance_mm",
           "Touches of one place that lie farther apart are repeated, "
           "samples_tolerance_retries times, then refused."},
      Word{"relative_reference_index",
           "The mesh's point that is called 0, counted along x first. Without one "
           "CALIBRATE_Z wants probe_bed_at_mm."},
      Word{"CALIBRATE_Z",
           "Klipper's command for z_calibration; its last line is `Z-CALIBRATION: "
           "ENDSTOP= NOZZLE= SWITCH= PROBE= --> OFFSET=`."}};
  return kWords;
}

}  // namespace caltwin
