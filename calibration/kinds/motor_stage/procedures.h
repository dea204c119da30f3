#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calibration/kinds/motor_stage/motor_axes.h"
#include "calibration/loop/outcome.h"

namespace caltwin {

/// Distances and speeds of the procedures; the published numbers where it has them.
/// Lengths are mm, of a rotary axis deg.
struct MotorOptions {
  bool is_as_published = false;
  std::vector<std::size_t> axes{0};
  double slow = 0.1;                      ///< Part of the highest speed: seeking.
  double medium = 0.5;                    ///< Likewise: backlash, stops, synchrony.
  std::optional<double> back_off_unit{};  ///< From a switch; 2 of a servo, 5 else.
  double second = 0.5;                    ///< Speed of a stepper's second approach.
  double final_back_off_unit = 1;         ///< Of a stepper, to its zero.
  double safe_unit = 10;                  ///< And from its switch to rest there.
  double distance_unit = 10;              ///< Of the backlash, and of moves together.
  int repeats = 3;              ///< Approaches from each side; moves together.
  int touches = 5;              ///< Fine approaches that a switch is told by.
  double fine_unit_s = 0.5;     ///< Their speed.
  double margin_unit = 2;       ///< Of the working range, at each end.
  double threshold_pulses = 3;  ///< Counter against index.
  double tolerance_unit = 0.2;  ///< Mechanical, of a backlash; a stop's unknown gap.
  int retries = 2;              ///< Each at half the speed.
  double within_s = 0.005;      ///< An emergency stop.
  double reach_sigmas = 6;  ///< An index nearer than this to a turn's end is warned of.
};

/// What a motor procedure found beside its estimates.
struct MotorFindings {
  int alerts = 0;   ///< Of the operator.
  int retries = 0;  ///< At lower speed.
  int warnings = 0;
  int safe_modes = 0;
  std::optional<int> index_edges{};
  std::optional<double> wrong_turn_probability{};  ///< Of the homing as published.
  std::optional<double> skew_s{};                  ///< Largest between axes, as left.
  std::optional<bool> stop_feasible{};             ///< Of the worst axis, foretold.
  std::optional<double> standstill_s{};            ///< Of the slowest axis, measured.
  std::optional<bool> stopped_within{};            ///< All of its servos, measured.
  int positions_lost = 0;                          ///< Axes, by an emergency stop.
  std::optional<double> lost_unit{};  ///< Of a stepper homed before; 0: no steps.
};

/// One entry of "What was done".
struct MotorDone {
  std::string quantity{};
  std::string unit{};              ///< Of before and after.
  std::optional<double> before{};  ///< Of the same quantity, where that is known.
  double after = 0;
  Verdict verdict = Verdict::kMeasured;
  std::string message{};
};

struct MotorResult {
  ProcedureResult result{};
  MotorFindings found{};
};

/// Seed 1.1: to the MIN switch, back off, on to the first index; that is zero.
/// As published zero is where the axis stands after stopping; corrected, the latched
/// count. Corrected, it warns where the switch's scatter can reach the index, and backs
/// off by half a turn more then; with a home offset stored before, it counts turns from
/// there.
MotorResult RunServoHome(MotorAxes* axes, const MotorOptions& options);

/// Seed 1.2. As published the counter is read twice: 10 mm for any gap. Corrected:
/// opposite approaches to one place, read by the gauge.
MotorResult RunMotorBacklash(MotorAxes* axes, const MotorOptions& options);

/// Seed 1.3: one turn, one index pulse, the count within the threshold; at half the
/// speed where not. As published it starts on the index, corrected half a turn off.
MotorResult RunIndexVerify(MotorAxes* axes, const MotorOptions& options);

/// Seed 2.1: the MIN switch in two touches. Corrected: several fine ones, their mean.
MotorResult RunStepperHome(MotorAxes* axes, const MotorOptions& options);

/// Seed 2.2: from home to the MAX switch; the working range between margins.
MotorResult RunTravelLimits(MotorAxes* axes, const MotorOptions& options);

/// Seed 3.1: all axes together; when each was half way. Corrected: delays that align
/// them are set, and tried.
MotorResult RunAxisSync(MotorAxes* axes, const MotorOptions& options);

/// Seed 3.2: a stop in mid-motion. Whether it can stand within 5 ms is foretold from
/// inertia, speed and current, then measured; what happened to positions; resume.
MotorResult RunEmergencyStop(MotorAxes* axes, const MotorOptions& options);

/// A stop that is asked about; lengths are mm, of a rotary axis deg.
struct StopAsked {
  double speed_unit_s = 0;
  double within_s = 0.005;
  double gap_unit =
      0;  ///< Between motor and load; the load is driven, on its far side.
  double gap_sd_unit = 0;
};

/// How long a servo brakes from a speed, input filter included:
///
///   t = t_filter + t_tick / 2 + v M / (F + friction)
///
/// (brakes act at the first tick after the filter: +- t_tick / sqrt(12))
/// while motor and load both move, also where a gap parts them: F brakes one, friction
/// the other, and what is left is shared when they meet. A motor that stands before its
/// load has crossed the gap b, b > v^2 (1 - aL / aM) / 2 aM, with aM = F / M_motor and
/// aL = friction / M_load, waits for it; that time is added, or v / aL is all where
/// friction stops the load inside the gap. Neglects rebound: rattling inside the gap.
///
/// Of a stepper its ramp, where its field holds it through that; else never. Its rotor
/// swings about the field with 2 pi sqrt(M / k), k = H 2 pi / cycle, when that stands.
struct StopForecast {
  double standstill_s = 0;
  /// From that of inertia and gap; of a stepper a quarter of its rotor's swing.
  double sd_s = 0;
  /// Of a servo, of those: from where its brake acts.
  double braked_s = 0, braked_sd_s = 0;
  double path_unit = 0;
  double fastest_unit_s = 0;     ///< That still stops in time, or still holds; 0: none.
  double fastest_sd_unit_s = 0;  ///< Of a stepper.
  bool holds = true;             ///< A stepper: keeps its steps.
  double coasts_s = 0;           ///< The load alone, its motor stands already.
};
StopForecast ForecastStop(const MotorBench& bench,
                          std::size_t axis,
                          const StopAsked& asked);

}  // namespace caltwin
