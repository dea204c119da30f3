#include <array>

#include "scenarios/kinds/motor_stage_effects.h"

namespace caltwin {

std::span<const Word> MotorEffectWords() {
  static constexpr std::array kWords = {
      Word{
          "backlash",
          "A gap between motor and carriage, which stays until it is crossed; friction "
          "stops the carriage. The motor's counter does not see it. gap_mm (gap_deg of "
          "a rotary axis)."},
      Word{
          "switch_scatter",
          "A limit switch closes at another place each time. sd_um: standard deviation "
          "from one closing to the next (sd_mdeg of a rotary axis, as all lengths are "
          "deg there). In `effects:` of a motor stage, switch_scatter.x."},
      Word{"switch_missing",
           "A limit switch that never closes: a wire is off. min: 1 or max: 1."},
      Word{"index_position",
           "Where the first index pulse stands beyond the MIN switch. from_switch_mm."},
      Word{"index_missing",
           "Index pulses that do not come through above a speed. above_mm_s; 0: none "
           "comes."},
      Word{
          "pulse_loss",
          "The encoder's counter loses a fraction of its pulses above a speed, and the "
          "drive, which follows its counter, goes as much too far. fraction, "
          "above_mm_s."},
      Word{"obstacle",
           "Something in the carriage's way. at_mm, on whichever side of its start."},
      Word{"load",
           "A load beside the drawn one. added_kg (of a rotary axis "
           "added_kg_m2); below 0: lighter."},
      Word{"rail_friction", "Friction beside the drawn one. added_n (added_n_m)."},
      Word{"start_delay",
           "The drive begins each move so much after it was told. delay_ms."},
      Word{"counter_edge",
           "An axis stands at power-up so much of a pulse beyond the edge at which its "
           "counter changes. part (0 to 1; 0: on the edge)."},
      Word{"start", "Where an axis stands at power-up. at_mm."}};
  return kWords;
}

std::span<const Word> MotorProcedureWords() {
  static constexpr std::array kWords = {
      Word{
          "servo_home",
          "Homes a servo: to the MIN switch at slow (0.1 of the highest speed), back "
          "off by back_off_mm (2), on to the first index pulse; that is zero. "
          "as_published takes where the axis stopped; corrected the latched count, "
          "warns where the switch's scatter can reach the index and backs off by half "
          "a "
          "turn more, looks at the switch again where the index is near the place that "
          "decides on its turn, and counts turns from a stored home offset. Lengths of "
          "a rotary axis are back_off_deg, likewise below. Troubles are logged "
          "and tried again at half the speed, retries times (2); then the operator is "
          "called and the axis is put in safe mode."},
      Word{"index_verify",
           "One turn of the motor has one index pulse, and the counter is within "
           "threshold_pulses (3) of it. as_published starts on the index and counts 0, "
           "1 "
           "or 2; corrected starts half a turn off. At half the speed where it fails."},
      Word{
          "stepper_home",
          "Homes an open-loop stepper on its MIN switch: slow, back off by back_off_mm "
          "(5), again at second (0.5) of the speed, back off by final_back_off_mm (1) "
          "to zero, rest at safe_mm (10) from the switch. corrected touches it touches "
          "(5) times at fine_mm_s (0.5) and takes the mean; of an axis homed before it "
          "tells the steps it had lost."},
      Word{"travel_limits",
           "From home to the MAX switch: the travel, and software limits margin_mm (2) "
           "within it."},
      Word{"axis_sync",
           "Moves axes together and reads from their counters when each was half way. "
           "axes: [x, y], distance_mm (10), repeats (3), medium (0.5). corrected sets "
           "the delays that align them and looks again. Of open-loop steppers nothing "
           "is known."},
      Word{"emergency_stop",
           "Foretells from inertia, speed (medium, 0.5) and current whether each of "
           "axes "
           "stands within_ms (5), its load coasting across the gap that motor_backlash "
           "measured; a gap that nobody measured, of tolerance_mm (0.2), is asked for "
           "where it would matter. Stops them in mid-motion, reads time, way and "
           "current "
           "of each, then resumes: a servo shows at its index whether its position was "
           "kept (but for whole turns), a stepper is homed again and shows its lost "
           "steps."},
      Word{
          "motor_backlash",
          "The gap between motor and carriage. as_published reads the motor's own "
          "counter twice: distance_mm (10) for any gap. corrected approaches one place "
          "from both sides and reads a gauge (instruments: {laser: {sigma_um: 0.5}}); "
          "beyond tolerance_mm (0.2) the operator is called."},
      Word{"power_cut",
           "A step: the power goes while lines are obeyed, after after_bytes (0) more "
           "bytes of the flash, and comes back: what the flash holds is in force, and "
           "no "
           "axis is homed. lines: [M500 X]."}};
  return kWords;
}

}  // namespace caltwin
