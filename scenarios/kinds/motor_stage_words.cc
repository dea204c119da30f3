#include <array>

#include "scenarios/kinds/motor_stage_scenario.h"

namespace caltwin {

std::span<const Word> MotorStageScenario::OwnEffects() const {
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

}  // namespace caltwin
