#include "scenarios/figure_words.h"

#include <array>

namespace caltwin {

namespace {

constexpr std::array kFigureWords = {
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
    Word{"index_edges", "Index pulses counted in one turn."},
    Word{"stopped_within",
         "1: every servo stood within within_ms, as measured; 0: one did not."},
    Word{"positions_lost", "Axes that lost their position in an emergency stop."},
    Word{"alerts", "How often the operator was called."},
    Word{"retries", "How often a procedure was tried again at half the speed."},
    Word{"warnings", "How often a procedure warned."},
    Word{"safe_modes", "How often an axis was switched off or slowed for safety."},
    Word{"history_entries", "Lines that the controller's error log holds (M504)."},
    Word{"said_mm", "The deviation that a delta's procedure states as its own."},
    Word{"height_error_mm",
         "How far a delta's nozzle, commanded to 0, stands from its bed over the "
         "disc: .rms, .most."},
    Word{"height_drift_mm",
         "By how much the nozzle's height has moved since the first procedure, rms."},
    Word{"height_reversal_mm",
         "The largest difference of the nozzle's height after moves down and moves "
         "up to one place: play of carriages."},
    Word{"xy_scale_um_per_mm", "By how much a delta's prints are too large."},
    Word{"gcode_offset_mm", "The G-code offset of z that is in force at the end."},
    Word{"position_error_mm",
         "The tip's position error at 1000 seeded poses, its mean left out: .p95."},
    Word{"machine_time_s", "How long the machine was at it."},
    Word{"touches", "How often the probe or nozzle touched."},
    Word{"wrong_turn_probability",
         "Share of homings that the switch's scatter would put on another turn's "
         "index."}};

}  // namespace

std::span<const Word> FigureWords() {
  return kFigureWords;
}

}  // namespace caltwin
