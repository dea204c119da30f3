#include "scenarios/figure_words.h"

#include <array>

namespace caltwin {

std::span<const Word> FigureWords() {
  static constexpr std::array kWords = {
      Word{"level_error_mm",
           "How far the bed of a triple-Z printer truly stands from its reference, on "
           "121 places within 20 mm of the edges: .mean of the magnitudes, .max."},
      Word{"flatness_mm",
           ".rms of how far that bed is from level, its mean height left out."},
      Word{"validation_mm",
           ".mean of the magnitudes of the procedure's own touches against the "
           "reference, at the points that it fitted."},
      Word{"hold_out_mm",
           ".mean of the magnitudes of touches between the points that were fitted "
           "(hold_out: true): what the fit cannot flatter."},
      Word{"predicted_factor",
           "By what each levelling round multiplies the tilt, foretold from single "
           "screws: the spectral radius of the loop's gain. Above 1 it diverges."},
      Word{"screw_offset", "By how much a screw was raised by levelling [mm]."},
      Word{"z_offset_error_mm",
           "How far from the print surface the clean nozzle truly stands when it is "
           "commanded to 0; positive: too high."},
      Word{"first_layer_error_mm",
           "The largest of that, by magnitude, on 121 places within 100 mm of the "
           "middle of the bed along x and y, the bed's mesh in force."},
      Word{"home_offset",
           "From where the MIN switch closes to the zero of a motor axis [mm, deg]."},
      Word{"home",
           "Where the zero of a motor axis truly stands beyond its MIN switch as drawn "
           "[mm, deg]."},
      Word{"travel", "From the zero of a motor axis to its MAX switch [mm, deg]."},
      Word{"compensated",
           "The gap that a motor controller believes in (M425) [mm, deg]."},
      Word{"start_lead",
           "By how much an axis is half way before the latest of those moved together "
           "[s]; a delay of as much aligns it."},
      Word{"skew_ms", "Between the earliest and the latest axis, as left."},
      Word{"standstill_ms",
           "From the emergency input to standstill, as the counter shows it; of the "
           "slowest servo."},
      Word{"stop_feasible",
           "1: every axis can stand within within_ms by its drawn mass, speed and "
           "current; 0: one cannot."},
      Word{"index_pulses", "Index pulses counted in one turn; also index_edges."},
      Word{"wrong_turn_probability",
           "Share of homings that the switch's scatter would put on another turn's "
           "index."}};
  return kWords;
}

}  // namespace caltwin
