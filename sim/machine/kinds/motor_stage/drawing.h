#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "sim/base/yaml.h"
#include "sim/machine/machine.h"

namespace caltwin {

/// Axes of a motor stage: x y z linear servos, a a rotary one, u v open-loop steppers.
inline constexpr std::size_t kNumMotorAxes = 6;
inline constexpr std::string_view kMotorAxisLetters = "xyzauv";

/// "x".
std::string MotorAxisName(std::size_t axis);
/// nullopt for what is none of them.
std::optional<std::size_t> MotorAxisNamed(std::string_view name);

/// One motor with its screw (or worm), carriage and limit switches, as drawn.
///
/// `unit` is mm, of a rotary axis deg. Masses are kg, of a rotary axis kg m2, forces N
/// or N m; the motor's own inertia is given as felt at the carriage.
struct MotorAxisDrawing {
  bool is_servo = true;  ///< Else an open-loop stepper.
  bool is_rotary = false;
  double min_unit = 0, max_unit = 200;  ///< Travel, as drawn from the zero.
  double lead_unit = 10;                ///< Travel a motor turn.
  double pulses_per_rev = 10'000;       ///< Counts of the encoder; of a stepper steps.
  double full_steps_per_rev = 200;      ///< Of a stepper; four make a magnetic cycle.
  double max_velocity_unit_s = 250;
  double acceleration_unit_s2 = 2500;
  double motor_inertia = 40;
  double load_inertia = 12;
  double friction = 10;  ///< Of the rail, or of the bearing.
  double force_per_amp = 300;
  /// Of a servo its drive's limit; of a stepper, times force_per_amp, what it holds.
  double current_limit_a = 12;
  double min_switch_unit = -8;  ///< Where the carriage closes the switch; on beyond it.
  double max_switch_unit = 208;          ///< Likewise.
  double switch_hysteresis_unit = 0.05;  ///< Travel back until it opens.
  /// Standard deviation from one closing to the next, by its data sheet.
  double switch_scatter_unit = 0.01;
  double stop_unit = 4;                 ///< The hard stops stand so far beyond.
  double index_from_switch_unit = 6.3;  ///< From the MIN switch to an index, towards +.

  double pulses_per_unit() const { return pulses_per_rev / lead_unit; }
  double total_inertia() const { return motor_inertia + load_inertia; }
  double largest_force() const { return force_per_amp * current_limit_a; }
  /// Metres a mm, radians a deg.
  double si_per_unit() const;
  const char* unit() const { return is_rotary ? "deg" : "mm"; }
  /// A thousandth of that.
  const char* fine_unit() const { return is_rotary ? "mdeg" : "um"; }
};

/// The rig: motors that do not know of each other, and what reads their switches.
struct MotorStageDrawing {
  std::string name{};
  std::filesystem::path model{};  ///< MJCF: its own, else the one that all can be.
  std::array<MotorAxisDrawing, kNumMotorAxes> axes{};
  double poll_s = 0.005;       ///< The expander is asked for its pins that often,
  double transfer_s = 0.0004;  ///< and its answer takes so long over the bus.
};

/// Reads `switch_expander`; the axes are as usual.
MotorStageDrawing ReadMotorStageDrawing(YamlMap* map);
/// Reads `axes` over what there is.
void ReadMotorAxes(YamlMap* map, MotorStageDrawing* stage);

/// The drawing of a motor stage; logic_error of another machine.
const MotorStageDrawing& MotorStageOf(const Machine& machine);

}  // namespace caltwin
